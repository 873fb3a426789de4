// Worst-case response times of periodic CAN frames.
//
// R. I. Davis, A. Burns, R. J. Bril, J. J. Lukkien, "Controller Area Network (CAN) schedulability analysis:
// Refuted, revisited and revised", Real-Time Systems 35, 2007, sections 3 and 4.
//
//   s, T, J, D         payload bytes, period, queueing jitter and deadline of frame m
//   C                  longest transmission time of frame m
//   C_k, T_k, J_k      the same for another frame k
//   B                  longest time for which a frame of lower priority blocks the bus
//   t                  busy period: the longest time without a pause between frames of hp and m
//   Q                  number of instances of frame m in the busy period
//   q                  index of one of these instances, 0..Q-1
//   w(q)               longest time from the start of the busy period until instance q begins on the bus
//   R                  worst-case response time of frame m
//   hp, lp             the frames of higher and of lower priority than m
//   g                  34, or 54 if the identifier is extended
//   tau_bit, tau_data  time of a bit at the nominal and at the data bit rate
//
//   C    = (g + 8 s + 13 + floor((g + 8 s - 1) / 4)) tau_bit        a classical frame
//   C    = (32 or 55) tau_bit + (10 s + 34 or 39) tau_data            CAN FD; 55 if extended, 39 if s > 16
//   B    = max of C over lp
//   t    = B + sum over hp and m:  ceil((t + J_k) / T_k) C_k                     the busy period
//   Q    = ceil((t + J) / T)
//   w(q) = B + q C + sum over hp:  ceil((w(q) + J_k + tau_bit) / T_k) C_k        instance q = 0..Q-1
//   R    = max over q of  J + w(q) - q T + C
//
// If errors occur, with at least the time T_e between two errors, t and w(q) have an additional term. E is
// the time that one error costs: an error frame, a pause and a repeated frame.
//
//   to t:      ceil(t / T_e) E
//   to w(q):   ceil((w(q) + C) / T_e) E
//   E        = 31 tau_bit + max of C over hp and m
//
// Assumptions: each node sends its waiting frames in the order of their priority; the bus has no other frames
// than those that are analysed; every receiver is as fast as the bus.
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
  Duration jitter{};  ///< longest time from the start of the period until the frame is queued
  Duration deadline{};
  bool fd = false;
  bool bit_rate_switch = false;  ///< for an FD frame: its data phase uses the data bit rate
};

struct FrameResponse {
  Duration transmission{};  ///< transmission time with all possible stuff bits and the interframe space
  Duration blocking{};      ///< longest transmission time of a frame of lower priority
  /// Worst-case response time, from the start of the period of the frame (jitter included) to the end of the
  /// interframe space after the frame; nullopt: the response time has no bound.
  std::optional<Duration> response;
  /// Number of the frame instance with the longest response time. Instances are counted from 0 in the busy
  /// period, the longest time without a pause on the bus.
  std::uint64_t instance = 0;
  bool schedulable = false;  ///< true if the response time is at most the deadline
};

struct Schedule {
  std::vector<FrameResponse> frames;  ///< results in the order of the given frames
  double load = 0.0;                  ///< sum of transmission time / period of all frames; 1: bus is full
};

/// Returns the number of bits of the longest frame with this payload size, stuff bits and interframe space
/// included: 135 for 8 bytes, 160 with an extended identifier. For CAN FD, the result is an upper limit: it
/// exceeds the longest frame by at most two bits of the data phase.
BitCount worst_frame_bits(const PeriodicFrame& frame);

/// Returns the longest transmission time of the frame. The nominal bit rate must be above 0.
Duration worst_transmission(const PeriodicFrame& frame, const BitRates& rates);

/// Computes the worst-case response times of all frames on a bus. `error_interval`: minimum time between two
/// errors on the bus; nullopt: no errors. Throws std::invalid_argument for a bit rate of 0, more than 64
/// bytes, an identifier that is too long for its type, a period not above 0, a negative jitter, two frames
/// with the same identifier, or an error interval not above 0.
Schedule analyse(std::span<const PeriodicFrame> frames, const BitRates& rates,
                 std::optional<Duration> error_interval = std::nullopt);

}  // namespace hystcan::can
