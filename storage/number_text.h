// Numbers as text.
#pragma once

#include <charconv>
#include <iterator>
#include <string>

namespace hystcan::storage {

/// Appends the shortest digits that read back to the same bits.
inline void append_shortest(std::string& text, double value) {
  char digits[32];
  text.append(std::begin(digits), std::to_chars(std::begin(digits), std::end(digits), value).ptr);
}

}  // namespace hystcan::storage
