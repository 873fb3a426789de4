// Worst-case response times of periodic CAN frames.
//
// R. I. Davis, A. Burns, R. J. Bril, J. J. Lukkien, "Controller Area Network (CAN) schedulability analysis:
// Refuted, revisited and revised", Real-Time Systems 35, 2007, sections 3 and 4.
//
//   s, T, J, D   bytes, period, queueing jitter and deadline of frame m
//   hp, lp       the frames of higher and of lower priority
//   g            34, or 54 if the identifier is extended
//
//   C    = (g + 8 s + 13 + floor((g + 8 s - 1) / 4)) tau_bit        a classical frame
//   C    = (32 or 55) tau_bit + (10 s + 34 or 39) tau_data            CAN FD; 55 if extended, 39 if s > 16
//   B    = max of C over lp
//   t    = B + sum over hp and m:  ceil((t + J_k) / T_k) C_k                     the busy period
//   Q    = ceil((t + J) / T)
//   w(q) = B + q C + sum over hp:  ceil((w(q) + J_k + tau_bit) / T_k) C_k        instance q = 0..Q-1
//   R    = max over q of  J + w(q) - q T + C
//
// Errors with at least the time T_e between them add a term to t and a term to w(q), for the error frame, the
// pause and the repeated frame:
//
//   to t:      ceil(t / T_e) E
//   to w(q):   ceil((w(q) + C) / T_e) E
//   E        = 31 tau_bit + max of C over hp and m
//
// Assumptions: each node sends its frames by priority; no node outside the set sends; a receiver is as fast
// as the bus.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "can/frame_bits.h"
#include "can/scheduler.h"

namespace hystcan::can {

struct PeriodicFrame {
  std::string name;
  std::uint32_t id = 0;
  bool extended = false;
  unsigned bytes = 8;
  Duration period{};  ///< for a sporadic frame, the minimum time between two frames
  Duration jitter{};  ///< maximum time from the start of the period until the frame is queued
  Duration deadline{};
  bool fd = false;
  bool bit_rate_switch = false;  ///< for an FD frame: its data phase uses the data bit rate
};

struct FrameResponse {
  Duration transmission{};  ///< C: transmission time with all possible stuff bits and the interframe space
  Duration blocking{};      ///< B: longest transmission time of a frame of lower priority
  /// Worst-case response time (R), from the start of the period (jitter included) to the end of the
  /// interframe space; nullopt: unbounded.
  std::optional<Duration> response;
  std::uint64_t instance = 0;  ///< q of the worst instance, counted from 0
  bool schedulable = false;    ///< the response time is within the deadline: R <= D
};

struct Schedule {
  std::vector<FrameResponse> frames;  ///< in the order of the input
  double load = 0.0;                  ///< sum of transmission time / period; the bus cannot carry more than 1
};

/// Returns the bits of the longest frame of this size, interframe space included: 135 for 8 bytes, 160 if
/// extended. For CAN FD, the result exceeds the longest frame with that identifier type by at most two data
/// bits.
BitCount worst_frame_bits(const PeriodicFrame& frame);

/// Returns the longest transmission time (C). The nominal bit rate must be above 0.
Duration worst_transmission(const PeriodicFrame& frame, const BitRates& rates);

/// `error_interval` is the minimum time between two errors on the bus; nullopt: no errors. Throws
/// std::invalid_argument for a bit rate of 0, more than 64 bytes, a period not above 0, a negative jitter,
/// two frames with the same identifier, or an error interval not above 0.
Schedule analyse(std::span<const PeriodicFrame> frames, const BitRates& rates,
                 std::optional<Duration> error_interval = std::nullopt);

}  // namespace hystcan::can
