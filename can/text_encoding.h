// What a text file of another machine begins with. Each function takes a whole text, or its first line as far as it was read.
#pragma once

#include <cstddef>
#include <string_view>

namespace hystcan::can {

inline constexpr std::string_view byte_order_mark =
    "\xEF\xBB\xBF";  ///< of UTF-8, as Windows' editors write it

constexpr std::string_view without_byte_order_mark(std::string_view text) {
  return text.starts_with(byte_order_mark) ? text.substr(byte_order_mark.size()) : text;
}

/// With its byte order mark, or as ASCII of which every other byte is zero.
constexpr bool is_utf16(std::string_view text) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) return true;
  const auto is_zero = [text](std::size_t at) { return text[at] == '\0'; };
  return text.size() >= 4 && is_zero(0) != is_zero(1) && is_zero(0) == is_zero(2) && is_zero(1) == is_zero(3);
}

/// True if nothing but CR ends its lines, as on old Macintoshes.
constexpr bool ends_lines_with_cr(std::string_view text) {
  return text.substr(0, text.empty() ? 0 : text.size() - 1).find('\r') != std::string_view::npos &&
         text.find('\n') == std::string_view::npos;
}

/// Why the text is no UTF-8 whose lines end with LF or CR LF, and what is expected; empty if it may be.
constexpr std::string_view refusal_of_encoding(std::string_view text) {
  if (is_utf16(text)) return "found UTF-16, expected UTF-8: save it as such";
  if (ends_lines_with_cr(text)) return "found lines that end with CR alone, expected LF or CR LF";
  return {};
}

}  // namespace hystcan::can
