// Worst-case response times of periodic CAN frames.
//
// R. I. Davis, A. Burns, R. J. Bril, J. J. Lukkien, "Controller Area Network (CAN) schedulability analysis:
// Refuted, revisited and revised", Real-Time Systems 35, 2007, sections 3 and 4. Frame m has bytes s, period
// T, queueing jitter J, deadline D; hp, lp: the frames of higher, of lower priority.
//
//   C = (g + 8 s + 13 + floor((g + 8 s - 1) / 4)) tau_bit        g = 34, 54 where extended
//   B = max of C over lp
//   t = B + sum over hp and m: ceil((t + J_k) / T_k) C_k           the busy period; Q = ceil((t + J) / T)
//   w(q) = B + q C + sum over hp: ceil((w + J_k + tau_bit) / T_k) C_k             instance q = 0..Q-1
//   R = max over q of  J + w(q) - q T + C
//
// With errors at least T_e apart, t and w get another  ceil((t or w + C) / T_e) (31 tau_bit + max of C over
// hp and m): error frame, pause, and the frame sent again.
//
// Assumed: each node's frames leave it in the order of their priority; nobody else sends; a receiver is as
// fast as the bus.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "can/scheduler.h"

namespace hystcan::can {

struct PeriodicFrame {
  std::string name;
  std::uint32_t id = 0;
  bool extended = false;
  unsigned bytes = 8;
  Duration period{};  ///< for a sporadic frame the least time between two
  Duration jitter{};  ///< how much later than its period says it may be queued
  Duration deadline{};
};

struct FrameResponse {
  Duration transmission{};  ///< C, with every stuff bit that may come and the interframe space
  Duration blocking{};      ///< B
  /// R, from the start of the period (jitter included) to the end of the interframe space. Empty: it grows
  /// without bound.
  std::optional<Duration> response;
  std::uint64_t instance = 0;  ///< q of the worst, counted from 0
  bool schedulable = false;    ///< R <= D
};

struct Schedule {
  std::vector<FrameResponse> frames;  ///< in the order given
  double load = 0.0;                  ///< sum of C / T; above 1 the bus cannot carry it

  bool schedulable() const;
};

/// Bits of the longest frame of so many bytes, interframe space included: 135 for 8 bytes, 160 extended.
/// Above 8 bytes an FD frame, counted as sent without a switch of bit rate.
unsigned worst_frame_bits(unsigned bytes, bool extended);

/// Identifier and its type as one number: of two frames the one with the lower wins arbitration.
std::uint64_t arbitration_order(const PeriodicFrame& frame);

/// C. `bitrate_bit_per_s` above 0.
Duration worst_transmission(const PeriodicFrame& frame, std::uint32_t bitrate_bit_per_s);

/// `error_interval`: least time between two errors on the bus; empty: no errors. Throws
/// std::invalid_argument: bit rate 0, more than 64 bytes, a period not above 0, a negative jitter, an
/// identifier that two share, an error interval not above 0.
Schedule analyse(std::span<const PeriodicFrame> frames, std::uint32_t bitrate_bit_per_s,
                 std::optional<Duration> error_interval = std::nullopt);

}  // namespace hystcan::can
