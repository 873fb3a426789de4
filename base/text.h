// Functions for texts in messages and files: format counts and numbers, parse numbers, and check the encoding
// of a text file.
#pragma once

#include <charconv>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>

namespace hystcan {

/// Returns a count with its noun, "1 frame" or "2 frames". `plural` is needed only for an irregular plural:
/// "2 axes".
inline std::string counted(std::uint64_t number, std::string_view noun, std::string_view plural = {}) {
  std::string text = std::to_string(number) + " ";
  if (number == 1) return text.append(noun);
  return plural.empty() ? text.append(noun) + "s" : text.append(plural);
}

/// Appends the shortest decimal number that reads back as exactly the same value.
template <class Number>
void append_shortest(std::string& text, Number value) {
  char digits[32];
  text.append(std::begin(digits), std::to_chars(std::begin(digits), std::end(digits), value).ptr);
}

/// Parses the whole text as a number, which may begin with a plus or minus sign. Returns `nullopt` if the
/// text is not a number, or if the number is outside the range of the type `Number`.
template <class Number>
std::optional<Number> parsed_number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  Number value{};
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error != std::errc() || end != last) return std::nullopt;
  return value;
}

/// Returns a number rounded to four significant digits, for a message.
inline std::string rounded(double value) {
  char digits[32];
  return {digits,
          std::to_chars(std::begin(digits), std::end(digits), value, std::chars_format::general, 4).ptr};
}

/// Returns true if the text contains a control character. TOML does not allow control characters unescaped,
/// and a terminal would execute them.
constexpr bool has_control_character(std::string_view text) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) return true;
  return false;
}

/// Returns the text with characters replaced: `by` lists each character with the text that replaces it.
inline std::string with_replaced(std::string_view text,
                                 std::initializer_list<std::pair<char, std::string_view>> by) {
  std::string result;
  for (const char& c : text) {
    std::string_view put(&c, 1);
    for (const auto& [from, to] : by)
      if (from == c) put = to;
    result += put;
  }
  return result;
}

/// Joins texts and numbers into one text. A number has all the digits that are needed to read back the same
/// value.
template <class... Parts>
std::string text_of(const Parts&... parts) {
  std::string text;
  const auto add = [&text](const auto& part) {
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(part)>>) {
      append_shortest(text, part);
    } else {
      text += part;
    }
  };
  (add(parts), ...);
  return text;
}

/// Throws std::invalid_argument. Its message consists of the parts, joined by text_of().
template <class... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  throw std::invalid_argument(text_of(parts...));
}

// The argument of the following functions is the whole text of a file, or its first part.

/// The byte order mark of UTF-8. Editors on Windows write it at the beginning of a file.
inline constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

constexpr std::string_view without_byte_order_mark(std::string_view text) {
  return text.starts_with(byte_order_mark) ? text.substr(byte_order_mark.size()) : text;
}

/// Returns true if the text begins with a byte order mark of UTF-16, or if it looks like ASCII in UTF-16:
/// every second one of its first four bytes is zero.
constexpr bool is_utf16(std::string_view text) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) return true;
  const auto is_zero = [text](std::size_t at) { return text[at] == '\0'; };
  return text.size() >= 4 && is_zero(0) != is_zero(1) && is_zero(0) == is_zero(2) && is_zero(1) == is_zero(3);
}

/// Returns true if the text has lines that end with CR, and no line feed, as on old Macintosh computers.
constexpr bool ends_lines_with_cr(std::string_view text) {
  return text.substr(0, text.empty() ? 0 : text.size() - 1).find('\r') != std::string_view::npos &&
         text.find('\n') == std::string_view::npos;
}

/// Returns a message if the text is UTF-16, or if its lines end with CR alone. Otherwise returns an empty
/// text.
constexpr std::string_view refusal_of_encoding(std::string_view text) {
  if (is_utf16(text)) return "found UTF-16, expected UTF-8: save the file as UTF-8";
  if (ends_lines_with_cr(text)) return "found lines that end with CR alone, expected LF or CR LF";
  return {};
}

}  // namespace hystcan
