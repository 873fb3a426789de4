// The worst-case response time of the chain of a cycle: SYNC, then sample, then command. Each of these frames
// is a link of the chain. docs/theory/bus.md has the derivation.
//
// q = 0 is a SYNC that finds no frame of the previous cycle, neither on the wire nor in the controller's
// queue.
// q = 1, 2, ... is the q-th SYNC after it, if frames were left over at each SYNC in between.
//
//   w(0) = own + L + sum over the frames before:  n_k(w(0)) C_k
//   w(q) = (q + 1) turnaround + sum over all other frames:  n_k(w(q)) C_k,   q + 1 of each link but the last
//   R    = max over q of  w(q) - q T + C
//
//   own      the links before the last one, and the turnaround. A command that waits for several samples
//            ends one chain for each sample; R is the greatest response of these chains
//   before   the frames with more priority than the weakest link; they may pass while a link waits. The
//            controller's queue is first in, first out, so that all commands count as the weakest command
//   L        the longest of the other frames, one for each link, which has begun when the link is queued
//   n_k(w)   ceil((w + J_k + tau_bit) / T_k)
//   J_k      the frame's own response, so that a frame that is left over at 0 counts; 0 for the frames of
//            the cycle, none of which is left over
//
// The controller queues its heartbeat and one axis status per cycle after the commands. Therefore w(0)
// contains neither, and w(q) contains at most q status frames in total, with the length of the longest. The
// frames that follow the last link also count q times in w(q). The J_k of a status is the time at which it
// may be queued, not the time at which its transmission ends.
//
// Frames in slots are sent only after the SYNC of their slot, one per cycle; `slots` cycles are one round.
// The controller then queues its own frame after SYNC. These frames are in none of the sums above, and none
// of them is left over at 0. Instead, w(q) contains D(q + 1), or D(q) if SYNC is the last link:
//
//   D(n)     the greatest sum, over n consecutive cycles, of the longest frame of each slot
//
// The controller's frame may have less priority than all others while commands are queued behind it; it then
// counts as the weakest link.
//
// From 0 to w(q), q > 0, the bus is idle only while a node of the chain works: the controller's heartbeat
// waits in the queue behind the commands of a cycle, and if it is sent before the next SYNC, that SYNC is a q
// = 0. q increases until all commands of a cycle and the heartbeat behind them are sent before the next SYNC.
//
// Assumptions:
//
//   - There are no errors, and every sample arrives. A command that is sent at its deadline, without a
//     sample, is sent no later than a command with its sample.
//   - Each node sends its frames by priority. The controller sends its frames in the order in which they
//     are queued, and it queues all other frames after the commands of the cycle.
//   - A node queues the frame of its slot within the turnaround after SYNC.
//   - There are no emergencies, NMT, SDO or status changes; these occur when an axis starts or stops.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "can/timing/schedulability.h"

namespace hystcan::can {

/// The purpose of a frame.
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

/// Returns true for the frames that occur in every cycle.
constexpr bool is_link(ChainRole role) {
  return role == ChainRole::sync || role == ChainRole::sample || role == ChainRole::command;
}

constexpr bool is_of_controller(ChainRole role) {
  return role == ChainRole::controller_status || role == ChainRole::controller_heartbeat;
}

struct ChainSource {
  PeriodicFrame frame;
  ChainRole role = ChainRole::heartbeat;
  /// The axes in the frame. A command waits for every sample that shares an axis with it.
  std::vector<std::size_t> axes;
  /// The cycle of a round in which the frame may be sent, 0..slots - 1; nullopt: at any time.
  std::optional<unsigned> slot{};
  /// Worst-case response time (R), from the start of the cycle for a link, from the start of its period for
  /// any other frame; nullopt: unbounded.
  std::optional<Duration> response{Duration::zero()};
};

struct ChainTiming {
  BitRates rates;
  Duration cycle{};
  Duration turnaround{};
  unsigned slots = 0;  ///< number of cycles in a round
};

/// Computes the response time (R) of the chain that ends with `last`, from the responses of the frames that
/// are not links. nullopt: unbounded.
std::optional<Duration> chain_response(std::span<const ChainSource> sources, const ChainSource& last,
                                       const ChainTiming& timing);

/// Computes every response. The responses of the links give the jitter of the other frames, and the responses
/// of the other frames change those of the links. The function repeats both steps until nothing changes.
/// (K. Tindell, J. Clark, "Holistic schedulability analysis for distributed hard real-time systems",
/// Microprocessing and Microprogramming 40, 1994.)
void respond(std::span<ChainSource> sources, const ChainTiming& timing);

}  // namespace hystcan::can
