// The worst-case response time of the chain of a control cycle. The chain consists of the frames SYNC, sample
// and command, in this order; each of these frames is a link. The last link is the frame whose response time
// is computed. docs/theory/bus.md has the derivation.
//
// A frame is left over at a SYNC if it is still on the wire or in the controller's transmit queue. q is
// the number of a SYNC. At SYNC 0, no frame of the previous cycle is left over. SYNC 0 begins at the time 0.
// SYNC q is the q-th SYNC after SYNC 0, if frames were left over at each SYNC from 1 to q.
//
//   w(0) = own + L + sum over the frames "before":  n_k(w(0)) C_k
//   w(q) = (q + 1) turnaround + sum over all frames k:  n_k(w(q)) C_k    for q > 0
//   R    = max over q of  w(q) - q T + C
//
//   w(q)     the latest time at which the transmission of the last link begins, in the cycle after SYNC q
//   R        the worst-case response time of the last link
//   T, T_k   the period of the cycle, and the period of frame k
//   C, C_k   the longest transmission time of the last link, and of frame k
//   n_k(w)   ceil((w + J_k + tau_bit) / T_k), the maximum number of frames k until the time w. In w(q), each
//            link before the last one counts q + 1 times instead, and the last link q times
//   J_k      the response time of frame k, so that a frame which is left over at the time 0 counts; 0 for the
//            links, because no link is left over at the time 0
//   tau_bit  the time of one bit
//   own      the transmission times of the links before the last one, and one turnaround: the time in which
//            sensor and controller queue their answers. own is 0 if SYNC is the last link. A command that
//            waits for several samples is the last link of one chain for each sample; R is the greatest
//            response time of these chains
//   before   the frames with a higher priority than the weakest link (the link with the lowest priority).
//            These frames may be sent while a link waits. The controller's queue is first in, first out.
//            Therefore every command counts as if it had the priority of the weakest command
//   L        the sum of the longest of all other frames, one frame for each link: when a link is queued, the
//            transmission of such a frame may have begun
//
// The controller queues its heartbeat and the status of one axis after the commands of a cycle. Therefore
// w(0) contains neither of these frames, and w(q) contains at most q statuses in total, each with the length
// of the longest status. A frame that answers the last link counts at most q times in w(q). For a status, J_k
// is the latest time at which it is queued, not its response time. If SYNC is the last link, w(q) contains
// only q turnarounds.
//
// If the bus has slots, a node sends its heartbeat or status only after the SYNC of its slot. A round has
// `slots` cycles; each cycle has at most one such frame. The controller queues its own frame after SYNC.
// The sums above do not contain the frames in slots, and none of these frames is left over at the time 0.
// Instead, w(q) contains the additional term D(q + 1), or D(q) if SYNC is the last link:
//
//   D(n)     the greatest total time of the frames in slots in n consecutive cycles; for each slot, the time
//            of its longest frame
//
// The commands of a cycle wait in the queue behind the controller's frame in a slot. This frame counts as the
// weakest link if it has a lower priority than all links.
//
// q increases until all commands of a cycle, and the controller's heartbeat behind them in the queue, are
// sent before the next SYNC. No frame is left over at this SYNC, so that it is again a SYNC with q = 0.
// Between the time 0 and w(q), the bus is idle only during a turnaround.
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

/// The purpose of a frame in a control cycle.
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

/// Returns true for a link of the chain SYNC, sample, command: a frame that occurs in every cycle.
constexpr bool is_link(ChainRole role) {
  return role == ChainRole::sync || role == ChainRole::sample || role == ChainRole::command;
}

constexpr bool is_of_controller(ChainRole role) {
  return role == ChainRole::controller_status || role == ChainRole::controller_heartbeat;
}

struct ChainSource {
  PeriodicFrame frame;
  ChainRole role = ChainRole::heartbeat;
  /// The axes whose values are in the frame. A command waits for every sample that shares an axis with the
  /// command.
  std::vector<std::size_t> axes;
  /// The slot of the frame: the only cycle of a round in which it may be sent, 0..slots - 1. nullopt: the
  /// frame has no slot and may be sent at any time.
  std::optional<unsigned> slot{};
  /// Worst-case response time. For SYNC, sample and command, it is counted from the start of the cycle. For
  /// any other frame, it is counted from the start of the period of the frame. nullopt: no upper limit.
  std::optional<Duration> response{Duration::zero()};
};

struct ChainTiming {
  BitRates rates;
  Duration cycle{};
  Duration turnaround{};
  /// Number of slots in a round. Each slot is one cycle; in its slot, a node may send its heartbeat or a
  /// status. 0: the bus has no slots, and nodes send these frames at any time.
  unsigned slots = 0;
};

/// Computes the worst-case response time of the chain that ends with the frame `last`. In `sources`, the
/// response times of all frames except SYNC, sample and command must be set. Returns nullopt if the response
/// time has no bound.
std::optional<Duration> chain_response(std::span<const ChainSource> sources, const ChainSource& last,
                                       const ChainTiming& timing);

/// Computes the response times of all frames in `sources`. The response times of the links (SYNC, sample,
/// command) determine the jitter of the other frames. The response times of the other frames change the
/// response times of the links. The function therefore repeats both steps until nothing changes. (K. Tindell,
/// J. Clark, "Holistic schedulability analysis for distributed hard real-time systems", Microprocessing and
/// Microprogramming 40, 1994.)
void respond(std::span<ChainSource> sources, const ChainTiming& timing);

}  // namespace hystcan::can
