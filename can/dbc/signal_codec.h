// Packs and unpacks one signal of a payload. The constructor prepares the layout from the DBC, so that
// packing and unpacking are fast.
#pragma once

#include <cstdint>
#include <span>

#include "can/dbc/database.h"

namespace hystcan::can {

/// Reads and writes the raw or the physical value of one signal:
///
///   physical = raw * scale + offset
class SignalCodec {
 public:
  /// Throws std::invalid_argument if the signal does not have 1 to 64 bits, or if an IEEE 754 signal does not
  /// have the width of its value type.
  explicit SignalCodec(const Signal& signal);

  /// Returns the raw value: an integer, or the bits of an IEEE 754 number. The payload must have at least
  /// bytes_needed(signal) bytes.
  std::int64_t unpack_raw(std::span<const std::uint8_t> payload) const;
  double unpack(std::span<const std::uint8_t> payload) const;

  /// Writes the low `length` bits of `raw` and changes no other bit of the payload.
  void pack_raw(std::int64_t raw, std::span<std::uint8_t> payload) const;

  /// Writes `physical`, rounded to the nearest raw value. A value never wraps: the function returns false and
  /// does not change the payload if `physical` is not finite, is outside the physical range, or does not fit
  /// into the bits of the signal. For an integer signal, the range is widened by a millionth of the
  /// resolution, so that a value from unpack() can be packed again. If the scale is 0, no value fits.
  [[nodiscard]] bool pack(double physical, std::span<std::uint8_t> payload) const;

  double minimum() const { return minimum_; }  ///< lower limit of the physical values that pack() accepts
  double maximum() const { return maximum_; }
  double resolution() const { return scale_; }  ///< physical value of one raw step of an integer signal
  std::size_t first_byte() const { return placement_.first_byte; }
  /// Returns true if the signal consists of exactly `count` whole bytes.
  bool fills_bytes(unsigned count) const {
    return length_ == 8 * count && placement_.last_byte - placement_.first_byte + 1 == count;
  }

 private:
  struct Placement {
    std::uint32_t first_byte;
    std::uint32_t last_byte;
    std::uint8_t shift;  ///< position of the signal's least significant bit in its byte
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
  double accepted_from_ = 0.0;  ///< lower limit of pack(): minimum_, lowered for rounding errors
  double accepted_to_ = 0.0;
  double raw_low_ = 0.0;  ///< lowest raw value that the signal can represent
  double raw_high_ = 0.0;
};

}  // namespace hystcan::can
