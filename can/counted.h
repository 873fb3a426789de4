// Counts in messages.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace hystcan::can {

/// "1 frame", "2 frames"; with the plural where it is irregular: "1 axis", "2 axes".
inline std::string counted(std::uint64_t number, std::string_view noun, std::string_view plural = {}) {
  std::string text = std::to_string(number) + " ";
  if (number == 1) return text.append(noun);
  return plural.empty() ? text.append(noun) + "s" : text.append(plural);
}

}  // namespace hystcan::can
