// The bits of a frame on the wire, and the time that they take (ISO 11898-1).
//
// A CAN FD frame with bit-rate switch and a payload of n bytes has three phases. The data phase uses the data
// bit rate:
//
//   nominal   start of frame, identifier, RRS, IDE, FDF, res, BRS        17 bits, 36 if extended
//   data      ESI, length code, payload, stuff count, CRC 17 or 21,      5 + 8 n + 28 bits if n <= 16,
//             fixed stuff bits, CRC delimiter                            5 + 8 n + 33 bits if n > 16
//   nominal   ACK slot and delimiter, end of frame, interframe space     12 bits
//
// The dynamic stuff bits of each phase are additional. The bit rate changes at the sample point of the bit
// BRS and of the CRC delimiter; together, these two bits take one nominal and one data bit time.
#pragma once

#include <cstdint>

#include "can/frame.h"
#include "can/scheduler.h"

namespace hystcan::can {

struct BitRates {
  std::uint32_t nominal_bit_per_s = 1'000'000;
  std::uint32_t data_bit_per_s = 0;  ///< bit rate of the data phase of CAN FD; 0: the bus does not switch the
                                     ///< bit rate

  friend bool operator==(const BitRates&, const BitRates&) = default;
};

/// Interframe space after every frame, in bits.
inline constexpr unsigned interframe_bits = 3;

/// The number of bits in a frame or in its first part, by bit rate. Stuff bits are included.
struct BitCount {
  unsigned nominal = 0;
  unsigned data = 0;  ///< bits in the data phase of a frame with bit-rate switch

  unsigned total() const { return nominal + data; }
};

/// The parts of a whole frame in wire order, from start of frame to the end of the interframe space, in bits.
struct FrameBits {
  unsigned head = 0;  ///< bits before the data phase; the whole frame if it has no data phase
  unsigned data = 0;
  unsigned tail = 0;

  unsigned total() const { return head + data + tail; }
  /// Returns how many of the first `bits` bits of the frame are sent at each bit rate.
  BitCount first(unsigned bits) const;
  BitCount all() const { return {.nominal = head + tail, .data = data}; }
};

/// Counts the bits of the frame, including the stuff bits that its content causes.
FrameBits frame_bits(const Frame& frame);

/// Returns the time that the bits take, rounded up to the next nanosecond. If the data bit rate is 0, all
/// bits use the nominal rate.
Duration transmission_time(const BitCount& bits, const BitRates& rates);

}  // namespace hystcan::can
