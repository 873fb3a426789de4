// Computes a number that identifies the parameters of a model. A saved memory contains this number, so that
// it cannot be restored into a model with other parameters.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string_view>

namespace hystcan::model {

/// A 64-bit hash (FNV-1a) of the bytes of all added values. The hash is the same on every machine and with
/// every compiler.
class Fingerprint {
 public:
  /// Adds the arguments to the hash, in the order in which they are passed. A value is a text, a number or a
  /// list of numbers.
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
