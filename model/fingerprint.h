// A number that identifies the parameters of a model. It prevents restoring a memory into another model.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string_view>

namespace hystcan::model {

/// FNV-1a, 64 bit, over the bytes of all added values. The result is the same on every machine and build.
class Fingerprint {
 public:
  /// Adds texts, numbers and lists of numbers.
  template <class... Values>
  void add(const Values&... values) {
    (add_value(values), ...);
  }
  std::uint64_t value() const { return hash_; }

 private:
  void add_value(std::string_view text) {
    for (const char c : text) add_byte(static_cast<unsigned char>(c));
    add_byte(0);
  }
  void add_value(double number) {
    const auto bits = std::bit_cast<std::uint64_t>(number);
    for (int shift = 0; shift < 64; shift += 8) add_byte((bits >> shift) & 0xff);
  }
  void add_value(std::span<const double> numbers) {
    add_value(static_cast<double>(numbers.size()));
    for (const double number : numbers) add_value(number);
  }
  void add_byte(std::uint64_t byte) { hash_ = (hash_ ^ byte) * 0x100000001b3u; }

  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

}  // namespace hystcan::model
