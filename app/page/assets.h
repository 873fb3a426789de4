// The files of the operator's page. cmake/page_assets.cmake embeds them in the program.
#pragma once

#include <span>
#include <string_view>

namespace hystcan::app {

struct Asset {
  std::string_view path;  ///< path in the browser's request, for example "/" or "/main.js"
  std::string_view type;  ///< value of the HTTP header Content-Type
  std::string_view content;
};

/// Returns the embedded files. There are none if the program was built without npm.
std::span<const Asset> page_assets();

inline bool page_is_built() { return !page_assets().empty(); }

}  // namespace hystcan::app
