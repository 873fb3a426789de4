// The files of the operator's page, which are embedded in the program (by cmake/page_assets.cmake).
#pragma once

#include <span>
#include <string_view>

namespace hystcan::app {

struct Asset {
  std::string_view path;  ///< path in a browser's request: "/", "/main.js"
  std::string_view type;  ///< value of Content-Type
  std::string_view content;
};

/// Empty if the program was built without npm.
std::span<const Asset> page_assets();

inline bool page_is_built() { return !page_assets().empty(); }

}  // namespace hystcan::app
