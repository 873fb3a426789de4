// The signals of a message of a DBC as the tables of node/firmware.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "can/protocol/protocol.h"
#include "node/firmware/hystcan_frame.h"

namespace hystcan::firmware {

inline constexpr double micro = 1e6;  ///< unit of the firmware's values

class Tables {
 public:
  Tables(const can::Database& database, const can::MessageMap& map, std::string drive_unit)
      : message_(can::find_message(database, map)), map_(map), drive_unit_(std::move(drive_unit)) {}

  hystcan_message message() const {
    const can::Frame frame{.kind = can::wire_kind(message_.length, message_.fd)};
    hystcan_message table{
        .id = message_.id,
        .extended = message_.extended,
        .kind = frame.kind == can::FrameKind::fd ? std::uint8_t{HYSTCAN_FD} : std::uint8_t{},
        .bit_rate_switch = message_.bit_rate_switch,
        .length = can::wire_length(static_cast<std::uint8_t>(message_.length)),
        .counter = {},
        .crc = {},
        .polynomial = HYSTCAN_NO_CRC,
        .data_id = static_cast<std::uint8_t>(map_.data_id.kind),
        .number = map_.data_id.number};
    if (map_.integrity == can::Integrity::none) return table;
    table.counter = field_of(can::find_signal(message_, map_.counter), 1.0);
    if (map_.integrity == can::Integrity::counter) return table;
    table.crc = field_of(can::find_signal(message_, map_.crc), 1.0);
    table.polynomial = static_cast<std::uint8_t>(HYSTCAN_SAE_J1850 + static_cast<int>(map_.polynomial));
    return table;
  }
  hystcan_field number(const char* role) const {
    const can::Signal* const signal = find(role);
    return signal == nullptr ? hystcan_field{} : field_of(*signal, 1.0);
  }
  hystcan_field drive(const char* role) const { return quantity(role, drive_unit_); }
  hystcan_field position(const char* role) const { return quantity(role, "um"); }

  /// Returns a value of the firmware as the twin reads it, to the bit.
  double to_physical(const char* role, const std::string& unit, std::int32_t value) const {
    const can::Signal& signal = *find(role);
    const hystcan_field table = quantity(role, unit);
    const double raw = static_cast<double>((std::int64_t{value} - table.offset) / table.scale);
    return step(signal, unit).to_ours(raw * signal.scale + signal.offset);
  }
  /// Returns the value of the nearest raw number, or the largest or smallest one if the signal cannot carry
  /// it.
  std::int32_t to_value(const char* role, const std::string& unit, double physical) const {
    const can::Signal& signal = *find(role);
    const can::SignalCodec codec(signal);
    const hystcan_field table = quantity(role, unit);
    const double theirs = step(signal, unit).to_theirs(physical);
    if (!(theirs >= codec.minimum())) return std::numeric_limits<std::int32_t>::min();
    if (!(theirs <= codec.maximum())) return std::numeric_limits<std::int32_t>::max();
    const auto raw = std::llrint((theirs - signal.offset) / signal.scale);
    return static_cast<std::int32_t>(raw * table.scale + table.offset);
  }

 private:
  /// Converts nothing if the drive has no unit.
  can::DecimalStep step(const can::Signal& signal, const std::string& unit) const {
    return drive_unit_.empty() ? can::DecimalStep{} : can::decimal_step(signal.unit, unit).value();
  }
  /// Returns null if the message has no signal for this role.
  const can::Signal* find(const char* role) const {
    const auto named = map_.signals.find(role);
    return named == map_.signals.end() ? nullptr : &can::find_signal(message_, named->second);
  }
  hystcan_field quantity(const char* role, const std::string& unit) const {
    const can::Signal* const signal = find(role);
    return signal == nullptr ? hystcan_field{} : field_of(*signal, step(*signal, unit).to_ours(micro));
  }
  /// `unit`: one unit of the DBC in the unit of the firmware.
  static hystcan_field field_of(const can::Signal& signal, double unit) {
    const can::SignalCodec codec(signal);
    const auto limited = [](double value) {
      using Limits = std::numeric_limits<std::int32_t>;
      return static_cast<std::int32_t>(
          std::clamp(std::round(value), double{Limits::min()}, double{Limits::max()}));
    };
    return {.start = static_cast<std::uint16_t>(signal.start_bit),
            .length = static_cast<std::uint8_t>(signal.length),
            .big_endian = signal.byte_order == can::ByteOrder::big_endian,
            .is_signed = signal.is_signed,
            .scale = static_cast<std::uint32_t>(std::llround(signal.scale * unit)),
            .offset = limited(signal.offset * unit),
            .minimum = limited(codec.minimum() * unit),
            .maximum = limited(codec.maximum() * unit)};
  }

  const can::Message& message_;
  can::MessageMap map_;
  std::string drive_unit_;
};

}  // namespace hystcan::firmware
