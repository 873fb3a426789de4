// The rule that Linux has for the names of network interfaces.
#pragma once

#include <algorithm>
#include <string_view>

namespace hystcan::can {

inline constexpr std::string_view expected_interface_name =
    "the name of an interface: 1 to 15 characters without spaces, / and :";

/// True if an interface can have this name: `vcan0`.
constexpr bool is_interface_name(std::string_view name) {
  constexpr std::size_t longest = 15;  // IFNAMSIZ less the final zero
  const auto fits = [](char c) { return c != '/' && c != ':' && c != ' ' && !(c >= '\t' && c <= '\r'); };
  return !name.empty() && name.size() <= longest && name != "." && name != ".." &&
         std::ranges::all_of(name, fits);
}

}  // namespace hystcan::can
