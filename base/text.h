// Functions for texts of messages and files: counts, digits, and the beginning of a text file.
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

/// "1 frame", "2 frames"; with an explicit irregular plural: "1 axis", "2 axes".
inline std::string counted(std::uint64_t number, std::string_view noun, std::string_view plural = {}) {
  std::string text = std::to_string(number) + " ";
  if (number == 1) return text.append(noun);
  return plural.empty() ? text.append(noun) + "s" : text.append(plural);
}

/// Appends the shortest digits that read back to the same bits.
template <class Number>
void append_shortest(std::string& text, Number value) {
  char digits[32];
  text.append(std::begin(digits), std::to_chars(std::begin(digits), std::end(digits), value).ptr);
}

/// Parses the whole text as a number; it may begin with a plus sign. Returns `nullopt` if the text is not a
/// number, or if `Number` cannot represent it.
template <class Number>
std::optional<Number> parsed_number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  Number value{};
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error != std::errc() || end != last) return std::nullopt;
  return value;
}

/// Returns a measured number with four digits, for a sentence.
inline std::string rounded(double value) {
  char digits[32];
  return {digits,
          std::to_chars(std::begin(digits), std::end(digits), value, std::chars_format::general, 4).ptr};
}

/// True if the text has a control character. TOML allows them only as an escape, and a terminal obeys them.
constexpr bool has_control_character(std::string_view text) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) return true;
  return false;
}

/// Returns the text with each of these characters replaced by the given text.
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

/// Joins words and numbers into one text. Each number has enough digits to restore its bits.
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

/// Throws std::invalid_argument with the joined parts as its text.
template <class... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  throw std::invalid_argument(text_of(parts...));
}

// The following functions take a whole text, or the first part of it that was read.

/// Byte order mark of UTF-8, which editors on Windows write.
inline constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

constexpr std::string_view without_byte_order_mark(std::string_view text) {
  return text.starts_with(byte_order_mark) ? text.substr(byte_order_mark.size()) : text;
}

/// True if the text has a UTF-16 byte order mark, or is ASCII in which every second byte is zero.
constexpr bool is_utf16(std::string_view text) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) return true;
  const auto is_zero = [text](std::size_t at) { return text[at] == '\0'; };
  return text.size() >= 4 && is_zero(0) != is_zero(1) && is_zero(0) == is_zero(2) && is_zero(1) == is_zero(3);
}

/// True if all lines end with CR only, as on old Macintoshes.
constexpr bool ends_lines_with_cr(std::string_view text) {
  return text.substr(0, text.empty() ? 0 : text.size() - 1).find('\r') != std::string_view::npos &&
         text.find('\n') == std::string_view::npos;
}

/// Returns why the text is not UTF-8 with lines that end in LF or CR LF, and what is expected; empty if it
/// may be.
constexpr std::string_view refusal_of_encoding(std::string_view text) {
  if (is_utf16(text)) return "found UTF-16, expected UTF-8: save it as such";
  if (ends_lines_with_cr(text)) return "found lines that end with CR alone, expected LF or CR LF";
  return {};
}

}  // namespace hystcan
