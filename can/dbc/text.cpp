#include "can/dbc/text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace hystcan::can::dbc {
namespace {

/// Code points of the bytes 0x80 to 0x9F in Windows-1252; the five undefined bytes keep their own value.
constexpr std::array<char16_t, 32> windows_1252 = {
    0x20AC, 0x0081, 0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021, 0x02C6, 0x2030, 0x0160,
    0x2039, 0x0152, 0x008D, 0x017D, 0x008F, 0x0090, 0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
    0x2013, 0x2014, 0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0x009D, 0x017E, 0x0178};

unsigned at(std::string_view text, std::size_t i) { return static_cast<unsigned char>(text[i]); }

/// Returns the length in bytes of the character at index `i`; 0 if this character is not well-formed UTF-8
/// (RFC 3629).
std::size_t character_bytes(std::string_view text, std::size_t i) {
  const unsigned lead = at(text, i);
  if (lead < 0x80) return 1;
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() - i < bytes) return 0;
  for (std::size_t k = 1; k < bytes; ++k) {
    if ((at(text, i + k) & 0xC0U) != 0x80U) return 0;
  }
  const unsigned second = at(text, i + 1);
  const bool overlong = (lead == 0xE0 && second < 0xA0) || (lead == 0xF0 && second < 0x90);
  const bool beyond = (lead == 0xED && second > 0x9F) || (lead == 0xF4 && second > 0x8F);
  return overlong || beyond ? 0 : bytes;
}

bool is_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t bytes = character_bytes(text, i);
    if (bytes == 0) return false;
    i += bytes;
  }
  return true;
}

void append_utf8(std::string& result, unsigned point) {
  const auto add = [&](unsigned byte) { result.push_back(static_cast<char>(byte)); };
  if (point < 0x80) return add(point);
  if (point < 0x800) {
    add(0xC0U | point >> 6U);
  } else {
    add(0xE0U | point >> 12U);
    add(0x80U | (point >> 6U & 0x3FU));
  }
  add(0x80U | (point & 0x3FU));
}

template <class Number>
std::optional<Number> to_whole(std::string_view text) {
  Number number = 0;
  if (text.starts_with('+')) text.remove_prefix(1);
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  if (hexadecimal) text.remove_prefix(2);
  const char* const text_end = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), text_end, number, hexadecimal ? 16 : 10);
  if (error == std::errc{} && end == text_end) return number;
  if (hexadecimal || error == std::errc::result_out_of_range) return std::nullopt;
  const auto real = to_real(text);
  constexpr double two_to_53 = 9007199254740992.0;
  const double lowest = std::numeric_limits<Number>::is_signed ? -two_to_53 : 0.0;
  if (!real || !(*real >= lowest && *real <= two_to_53) || std::floor(*real) != *real) return std::nullopt;
  return static_cast<Number>(*real);
}

}  // namespace

std::string to_utf8(std::string_view text) {
  if (is_utf8(text)) return std::string(text);
  std::string result;
  result.reserve(2 * text.size());
  for (const char c : text) {
    const unsigned byte = static_cast<unsigned char>(c);
    append_utf8(result, byte >= 0x80 && byte < 0xA0 ? windows_1252[byte - 0x80] : byte);
  }
  return result;
}

std::string unescaped(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.substr(i, 2) == "\\\"") ++i;
    result.push_back(text[i]);
  }
  return to_utf8(result);
}

std::optional<std::uint64_t> to_natural(std::string_view text) { return to_whole<std::uint64_t>(text); }
std::optional<std::int64_t> to_integer(std::string_view text) { return to_whole<std::int64_t>(text); }

std::optional<double> to_real(std::string_view text) {
  const auto mark = text.find('#');
  if (mark != std::string_view::npos) {
    if (text.substr(mark + 1) != "INF") return std::numeric_limits<double>::quiet_NaN();
    return text.starts_with('-') ? -std::numeric_limits<double>::infinity()
                                 : std::numeric_limits<double>::infinity();
  }
  if (text.starts_with("0x") || text.starts_with("0X")) {
    const auto natural = to_natural(text);
    return natural ? std::optional(static_cast<double>(*natural)) : std::nullopt;
  }
  double number = 0.0;
  if (text.starts_with('+')) text.remove_prefix(1);
  const char* const text_end = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), text_end, number);
  if (end != text_end) return std::nullopt;
  if (error == std::errc::result_out_of_range) return std::strtod(std::string(text).c_str(), nullptr);
  return error == std::errc{} ? std::optional(number) : std::nullopt;
}

}  // namespace hystcan::can::dbc
