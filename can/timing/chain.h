// The worst-case response time of the chain of a cycle: SYNC, then sample, then command.
// docs/theory/bus.md derives it.
//
// q = 0 is a SYNC that finds no frame of the cycle before, neither on the wire nor in the controller's queue.
// q = 1, 2, ... is the q-th SYNC after it, if frames were left over at each SYNC in between.
//
//   w(0) = own + L + sum over the frames before:  n_k(w(0)) C_k
//   w(q) = (q + 1) turnaround + sum over all other frames:  n_k(w(q)) C_k,   q + 1 of each link but the last
//   R    = max over q of  w(q) - q T + C
//
//   own      the links before the last one, and the turnaround. A command that waits for several samples
//            is the end of one chain with each of them; R is the greatest
//   before   the frames with more priority than the weakest link; they may pass while a link waits. The
//            controller's queue is first in, first out, so that all commands count as the weakest command
//   L        the longest of the other frames, one for each link, which has begun when the link is queued
//   n_k(w)   ceil((w + J_k + tau_bit) / T_k)
//   J_k      the frame's own response, so that a frame that is left over at 0 counts; 0 for the frames of
//            the cycle, none of which is left over
//
// The controller queues its heartbeat and one axis status a cycle behind the commands. Therefore w(0)
// contains neither, and w(q) contains at most q of all statuses together, with the length of the longest. The
// frames that follow from the last link also count q times in w(q). The J_k of a status is the time at which
// it may be queued and not the time at which it has passed.
//
// Frames in slots come only after the SYNC of their slot in a round of so many cycles, one in a cycle; then
// the controller queues its own behind SYNC. They are in none of the sums above, and none of them is left
// over at 0. Instead w(q) contains D(q + 1), or D(q) where SYNC is the last link:
//
//   D(n)     the greatest sum over n cycles in succession, of the longest frame of each slot
//
// The controller's frame may have less priority than all others and the commands are queued behind it, so
// that it counts as a weakest link.
//
// From 0 to w(q), q > 0, the bus is idle only while a node of the chain works: the controller's heartbeat
// waits in the queue behind the commands of a cycle, and if it passes before the next SYNC, that SYNC is a
// q = 0. q increases until all commands of a cycle and a heartbeat behind them pass before the next SYNC.
//
// Assumptions:
//
//   - There are no errors, and every sample comes. A command that goes out at its deadline, before a sample
//     has come, goes out no later than with it.
//   - The frames of a node leave it by priority. Those of the controller leave in the order in which they are
//     queued, and it queues all other frames behind the commands of the cycle.
//   - A node queues the frame of its slot within the turnaround after SYNC.
//   - There are no emergencies, NMT, SDO or status changes; they come when an axis starts or stops.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "can/timing/schedulability.h"

namespace hystcan::can {

/// Why a frame is sent.
enum class ChainRole {
  sync,
  sample,
  command,
  status,
  controller_status,
  controller_heartbeat,
  live_setpoint,
  heartbeat
};

/// True for the frames that every cycle has.
constexpr bool is_link(ChainRole role) {
  return role == ChainRole::sync || role == ChainRole::sample || role == ChainRole::command;
}

constexpr bool is_of_controller(ChainRole role) {
  return role == ChainRole::controller_status || role == ChainRole::controller_heartbeat;
}

struct ChainSource {
  PeriodicFrame frame;
  ChainRole role = ChainRole::heartbeat;
  /// Those that the frame carries. A command waits for every sample with which it shares an axis.
  std::vector<std::size_t> axes;
  /// The cycle of a round in which the frame may come, 0..slots - 1. Empty: it comes at any time.
  std::optional<unsigned> slot{};
  /// R, from the start of the cycle for a link and from the start of its period for any other frame. Empty:
  /// unbounded.
  std::optional<Duration> response{Duration::zero()};
};

struct ChainTiming {
  BitRates rates;
  Duration cycle{};
  Duration turnaround{};
  unsigned slots = 0;  ///< cycles in a round
};

/// R of the chain that ends with `last`, by the responses of the frames that are no links. Empty: unbounded.
std::optional<Duration> chain_response(std::span<const ChainSource> sources, const ChainSource& last,
                                       const ChainTiming& timing);

/// Computes every response. The responses of the links give the jitter of the other frames, and the responses
/// of the other frames change those of the links. The function repeats both until nothing changes.
/// (K. Tindell, J. Clark, "Holistic schedulability analysis for distributed hard real-time systems",
/// Microprocessing and Microprogramming 40, 1994.)
void respond(std::span<ChainSource> sources, const ChainTiming& timing);

}  // namespace hystcan::can
