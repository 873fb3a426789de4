// Packs and unpacks one signal. The plan is compiled once from the DBC; using it touches no string.
#pragma once

#include <cstdint>
#include <span>

#include "can/dbc/database.h"

namespace hystcan::can {

/// Raw and physical access to one signal of a message:  physical = raw * scale + offset.
class SignalCodec {
 public:
  /// Throws std::invalid_argument where the signal does not have 1..64 bits, or those that its value type
  /// needs.
  explicit SignalCodec(const Signal& signal);

  /// The payload must hold the signal: bytes_needed(signal).
  /// The integer; of an IEEE 754 number its bits as they stand.
  std::int64_t unpack_raw(std::span<const std::uint8_t> payload) const;
  double unpack(std::span<const std::uint8_t> payload) const;

  /// Writes the low `length` bits of `raw`, leaving every other bit of the payload as it is.
  void pack_raw(std::int64_t raw, std::span<std::uint8_t> payload) const;

  /// Rounds to the nearest raw value. False, and the payload untouched, where `physical` is not finite,
  /// outside the stated physical range (by more than a millionth of the resolution, so that what unpack()
  /// gives can be packed again), or not representable in the signal's bits, which with a scale of 0 nothing
  /// is: a value never wraps.
  [[nodiscard]] bool pack(double physical, std::span<std::uint8_t> payload) const;

  double minimum() const { return minimum_; }  ///< physical range that pack() accepts
  double maximum() const { return maximum_; }
  double resolution() const { return scale_; }  ///< of an integer signal

 private:
  struct Placement {
    std::uint32_t first_byte;
    std::uint32_t last_byte;
    std::uint8_t shift;  ///< of the signal's least significant bit within the byte that holds it
  };

  static void check(const Signal& signal);
  static Placement place(const Signal& signal);
  void set_integer_range(const Signal& signal);
  void set_float_range(const Signal& signal);
  std::uint64_t load(std::span<const std::uint8_t> payload) const;
  void store(std::uint64_t bits, std::span<std::uint8_t> payload) const;
  std::uint64_t bits_of(double raw) const;

  Placement placement_{};
  std::uint8_t length_ = 0;
  ByteOrder byte_order_ = ByteOrder::little_endian;
  bool is_signed_ = false;
  ValueType value_type_ = ValueType::integer;
  double scale_ = 1.0;
  double offset_ = 0.0;
  double minimum_ = 0.0;
  double maximum_ = 0.0;
  double accepted_from_ = 0.0;  ///< the physical range, widened by what rounding may add
  double accepted_to_ = 0.0;
  double raw_low_ = 0.0;  ///< representable raw values
  double raw_high_ = 0.0;
};

}  // namespace hystcan::can
