// The bits of a frame on the wire, and the time that they take (ISO 11898-1).
//
// A CAN FD frame with bit-rate switch has a data phase, which passes at the data bit rate:
//
//   nominal   start of frame, identifier, RRS, IDE, FDF, res, BRS        17 bits, 36 if extended
//   data      ESI, length code, payload, stuff count, CRC 17 or 21,      8 n + 5 + 28, or + 33 above 16 bytes
//             fixed stuff bits, CRC delimiter
//   nominal   ACK slot and delimiter, end of frame, interframe space     12 bits
//
// and the dynamic stuff bits of each phase. The bit rate switches within BRS and within the CRC delimiter, at
// their sample points; together the two take one nominal and one data bit time.
#pragma once

#include <cstdint>

#include "can/frame.h"
#include "can/scheduler.h"

namespace hystcan::can {

struct BitRates {
  std::uint32_t nominal_bit_per_s = 1'000'000;
  std::uint32_t data_bit_per_s = 0;  ///< of the data phase of CAN FD; 0: the bus has no bit-rate switch

  friend bool operator==(const BitRates&, const BitRates&) = default;
};

/// Bits of interframe space after every frame.
inline constexpr unsigned interframe_bits = 3;

/// The bits of a frame or of its first part, stuff bits included.
struct BitCount {
  unsigned nominal = 0;
  unsigned data = 0;  ///< those of the data phase of a frame with bit-rate switch

  unsigned total() const { return nominal + data; }
};

/// The bits of a whole frame, from start of frame to the end of the interframe space, in their order.
struct FrameBits {
  unsigned head = 0;  ///< before the data phase; the whole frame if it has none
  unsigned data = 0;
  unsigned tail = 0;

  unsigned total() const { return head + data + tail; }
  /// The first `bits` bits of the frame.
  BitCount first(unsigned bits) const;
  BitCount all() const { return {.nominal = head + tail, .data = data}; }
};

/// With the stuff bits of the frame's content.
FrameBits frame_bits(const Frame& frame);

/// Rounded up to the next nanosecond. Without a data bit rate all bits pass at the nominal one.
Duration transmission_time(const BitCount& bits, const BitRates& rates);

}  // namespace hystcan::can
