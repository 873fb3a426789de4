// The files of the operator's page, which lie within the program (cmake/page_assets.cmake puts them there).
#pragma once

#include <span>
#include <string_view>

namespace hystcan::app {

struct Asset {
  std::string_view path;  ///< as a browser asks for it: "/", "/main.js"
  std::string_view type;  ///< for Content-Type
  std::string_view content;
};

/// Empty in a program that was built without npm.
std::span<const Asset> page_assets();

inline bool page_is_built() { return !page_assets().empty(); }

}  // namespace hystcan::app
