// The frames that follow from each other in a cycle, SYNC to sample to command, and how long they may take.
// docs/theory.md, section 12.
//
//   A SYNC at 0 that finds nothing of the cycle before, on the wire or in the controller's queue:
//     w(0) = own + L + sum over the frames before:  n_k(w(0)) C_k
//   The q-th SYNC after it, q = 1, 2, ..., where something was left over each time in between:
//     w(q) = (q + 1) turnaround + sum over all other frames:  n_k(w(q)) C_k,   q + 1 of each link but the
//     last
//   R    = max over q of  w(q) - q T + C
//
//   own      the links up to the last, without the last, and the turnaround
//   before   what may pass while a link waits: goes before the weakest link. The controller's queue is first
//            in, first out, so that all commands count as the weakest of them
//   L        of the other frames the longest, one for each link: what had begun when the link was queued
//   n_k(w)   ceil((w + J_k + tau_bit) / T_k);  J_k: the frame's own response, so that one left over at 0
//            counts; 0 for the frames of the cycle, of which nothing is
//
//   Axis statuses of the controller go out one a cycle, queued behind its commands: none of them in w(0), and
//   in w(q) all together at most q, the longest. What follows from the last link counts q times there too.
//   Their J_k is when they may be queued, not when they are through.
//
// From 0 to w(q), q > 0, the bus is never idle but while a node of the chain is at work: after the commands
// of a cycle the controller's heartbeat waits in its queue, and where it has gone before the next SYNC, that
// SYNC is a q = 0. q counts on until all commands of a cycle and a heartbeat behind them are through in time.
//
// Assumed: no errors, every sample comes; a node's frames leave it by priority, the controller's in the order
// in which they are queued, and its housekeeping behind the commands of the cycle; no emergencies, NMT, SDO
// or status changes, which come where an axis starts or stops.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "can/timing/schedulability.h"

namespace hystcan::can {

/// How a frame comes to be sent.
enum class ChainRole { sync, sample, command, status, controller_status, live_setpoint, heartbeat };

/// Of the frames that every cycle has.
constexpr bool is_link(ChainRole role) {
  return role == ChainRole::sync || role == ChainRole::sample || role == ChainRole::command;
}

struct ChainSource {
  PeriodicFrame frame;
  ChainRole role = ChainRole::heartbeat;
  std::size_t axis = 0;
  /// R: of links from the start of the cycle, of the others from the start of their period. Empty: unbounded.
  std::optional<Duration> response{Duration::zero()};
};

struct ChainTiming {
  std::uint32_t bitrate_bit_per_s = 1'000'000;
  Duration cycle{};
  Duration turnaround{};
};

/// R of the chain that ends with `last`, given the responses of what is no link. Empty: without bound.
std::optional<Duration> chain_response(std::span<const ChainSource> sources, const ChainSource& last,
                                       const ChainTiming& timing);

/// Fills in every response: those of the links make the jitter of the others, and the others' theirs, until
/// nothing changes (K. Tindell, J. Clark, "Holistic schedulability analysis for distributed hard real-time
/// systems", Microprocessing and Microprogramming 40, 1994).
void respond(std::span<ChainSource> sources, const ChainTiming& timing);

}  // namespace hystcan::can
