// Writes the memory of a hysteresis model as a [memory] table (TOML) into a fixed buffer, without allocating.
// Each number has enough digits to restore exactly the same value. The key `model` is the fingerprint of the
// model (model/fingerprint.h). Example:
//
//   [memory]
//   kind = "recursive-memory"
//   model = "8f3b52c1d07e9a64"
//   origin = "virgin"
//   turning_inputs = [80.0, 20.5]
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string_view>
#include <system_error>

namespace hystcan::model {

class MemoryText {
 public:
  /// Maximum length of one number with its comma, in characters. All other text of the table needs less than
  /// 400 characters.
  static constexpr std::size_t number_size = 26;

  MemoryText(std::span<char> buffer, std::string_view kind, std::uint64_t fingerprint) : buffer_(buffer) {
    append("[memory]\nkind = \"");
    append(kind);
    append("\"\nmodel = \"");
    for (int shift = 60; shift >= 0; shift -= 4)
      append(std::string_view("0123456789abcdef").substr((fingerprint >> shift) & 0xf, 1));
    append("\"\n");
  }

  void line(std::string_view key, std::string_view text) {
    begin(key);
    append("\"");
    append(text);
    append("\"\n");
  }
  void line(std::string_view key, double number) {
    begin(key);
    append_number(number);
    append("\n");
  }
  void line(std::string_view key, std::size_t count) {
    char digits[20];
    const auto [end, error] = std::to_chars(std::begin(digits), std::end(digits), count);
    begin(key);
    append(std::string_view(digits, static_cast<std::size_t>(end - digits)));
    append("\n");
  }
  /// Writes a line `key = [...]` with one number for each element of `range`. `number_of(element)` returns
  /// the number.
  template <class Range, class NumberOf>
  void list(std::string_view key, const Range& range, NumberOf number_of) {
    begin(key);
    append("[");
    const char* separator = "";
    for (const auto& element : range) {
      append(separator);
      append_number(number_of(element));
      separator = ", ";
    }
    append("]\n");
  }

  /// Returns the written text; empty if the buffer was too small.
  std::string_view text() const {
    return fits_ ? std::string_view(buffer_.data(), size_) : std::string_view();
  }

 private:
  void begin(std::string_view key) {
    append(key);
    append(" = ");
  }
  void append(std::string_view text) {
    fits_ = fits_ && text.size() <= buffer_.size() - size_;
    if (!fits_) return;
    std::ranges::copy(text, buffer_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += text.size();
  }
  void append_number(double number) {
    char digits[32];
    const auto [end, error] = std::to_chars(std::begin(digits), std::end(digits), number);
    fits_ = fits_ && error == std::errc();
    const std::string_view text(digits, static_cast<std::size_t>(end - digits));
    append(text);
    // TOML would read a number without ".0" as an integer.
    if (text.find_first_of(".en") == std::string_view::npos) append(".0");
  }

  std::span<char> buffer_;
  std::size_t size_ = 0;
  bool fits_ = true;
};

}  // namespace hystcan::model
