// Error messages of the models for parameters that they cannot use.
#pragma once

#include <charconv>
#include <iterator>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace hystcan::model {

/// Joins words and numbers into one text. Each number has the digits that restore its bits.
template <class... Parts>
std::string text_of(const Parts&... parts) {
  std::string text;
  const auto add = [&text](const auto& part) {
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(part)>>) {
      char digits[32];
      text.append(digits, std::to_chars(std::begin(digits), std::end(digits), part).ptr);
    } else {
      text += part;
    }
  };
  (add(parts), ...);
  return text;
}

/// A measured number in a sentence, with four digits.
inline std::string rounded(double value) {
  char digits[32];
  return {digits,
          std::to_chars(std::begin(digits), std::end(digits), value, std::chars_format::general, 4).ptr};
}

template <class... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  throw std::invalid_argument(text_of(parts...));
}

}  // namespace hystcan::model
