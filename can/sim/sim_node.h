// One node of the simulated bus: its queue, its fault confinement, its way back from bus-off. Internal to the
// simulated bus.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "can/bus.h"
#include "can/sim/fault_confinement.h"
#include "can/sim/sim_bus.h"

namespace hystcan::can::sim {

inline constexpr std::uint32_t never = 0xFFFF'FFFF;

/// The arbitration field as a number, in the order in which its bits pass: the lowest wins.
inline std::uint32_t arbitration_key(const Frame& frame) {
  const std::uint32_t remote = frame.kind == FrameKind::remote ? 1 : 0;
  if (!frame.extended) return frame.id << 21U | remote << 20U;
  return frame.id >> 18U << 21U | std::uint32_t{3} << 19U | (frame.id & 0x3FFFFU) << 1U | remote;
}

inline bool can_be_sent(const Frame& frame) {
  if (frame.id > (frame.extended ? 0x1FFF'FFFFU : 0x7FFU)) return false;
  switch (frame.kind) {
    case FrameKind::data:
    case FrameKind::remote:
      return frame.length <= 8;
    case FrameKind::fd:
      return frame.length <= frame.data.size();
    case FrameKind::error:
      return false;
  }
  return false;
}

/// From bus-off: `waiting` for the restart request, then `counting` recessive bits.
enum class Recovery : std::uint8_t { none, waiting, counting };

struct Node {
  explicit Node(TransmitOrder its_order) : order(its_order) {}

  const TransmitOrder order;
  Bus::FrameHandler on_frame;
  Bus::StateHandler on_state;
  BusCounters counters;
  std::array<Frame, SimBus::transmit_queue_length> queue;
  std::size_t oldest = 0;
  std::size_t queued = 0;
  Frame returned;  ///< destroyed on the wire, to be sent again before the queue
  bool sends_again = false;
  std::uint32_t key = never;  ///< of the frame to be sent next
  bool attached = true;
  bool off = false;      ///< bus-off
  bool missed = false;   ///< an error-passive node's error in the frame on the wire
  Time suspended_until;  ///< suspend transmission
  FaultConfinement confinement;
  BusState told = BusState::active;
  NodeFaults faults;
  Recovery recovery = Recovery::none;
  unsigned sequences_left = 0;  ///< of recessive bits
  Time recessive_since;
  std::unique_ptr<Timer> recovery_timer;

  bool listens() const { return attached && !off; }

  /// False: refused.
  bool push(const Frame& frame) {
    if (off || queued == queue.size() || !can_be_sent(frame)) return false;
    std::size_t place = queued++;
    if (order == TransmitOrder::by_priority) {
      for (; place > 0 && arbitration_key(frame) < arbitration_key(at(place - 1)); --place)
        at(place) = at(place - 1);
    }
    at(place) = frame;
    if (place == 0) choose();
    return true;
  }

  const Frame& pop() {
    if (returned_is_next()) {
      sends_again = false;
      choose();
      return returned;
    }
    const Frame& frame = at(0);
    oldest = (oldest + 1) % queue.size();
    --queued;
    choose();
    return frame;
  }

  void give_back(const Frame& frame) {
    returned = frame;
    sends_again = true;
    choose();
  }

  void forget_frames() {
    queued = 0;
    sends_again = false;
    key = never;
  }

 private:
  Frame& at(std::size_t place) { return queue[(oldest + place) % queue.size()]; }
  bool returned_is_next() {
    return sends_again && (order == TransmitOrder::as_sent || queued == 0 ||
                           arbitration_key(returned) <= arbitration_key(at(0)));
  }
  void choose() {
    key = returned_is_next() ? arbitration_key(returned) : queued == 0 ? never : arbitration_key(at(0));
  }
};

}  // namespace hystcan::can::sim
