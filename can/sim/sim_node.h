// One node of the simulated bus: its queue, its fault confinement and its recovery from bus-off. Internal to
// the simulated bus.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "can/bus.h"
#include "can/sim/fault_confinement.h"
#include "can/sim/sim_bus.h"

namespace hystcan::can::sim {

inline constexpr std::uint32_t never = 0xFFFF'FFFF;

/// The arbitration field as a number, in the order of its bits on the wire. The lowest number wins.
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

/// After bus-off a node is `waiting` for the restart request and then `counting` recessive bits.
enum class Recovery : std::uint8_t { none, waiting, counting };

struct Node {
  explicit Node(TransmitOrder transmit_order) : order(transmit_order) {}

  const TransmitOrder order;
  Bus::FrameHandler on_frame;
  Bus::FrameHandler on_sent;
  Bus::StateHandler on_state;
  BusCounters counters;
  std::array<Frame, SimBus::transmit_queue_length> queue;
  std::size_t oldest = 0;
  std::size_t queued = 0;
  Frame returned;  ///< the frame that was destroyed on the wire; it is sent again before the queue
  bool sends_again = false;
  std::uint32_t key = never;  ///< arbitration key of the frame to send next
  bool attached = true;
  bool off = false;      ///< bus-off
  bool missed = false;   ///< the node is error-passive and has an error in the frame on the wire
  Time suspended_until;  ///< end of the pause of an error-passive node
  FaultConfinement confinement;
  BusState reported = BusState::active;  ///< the state that the handler got last
  NodeFaults faults;
  Recovery recovery = Recovery::none;
  unsigned sequences_left = 0;  ///< sequences of recessive bits that are still to come
  Time recessive_since;
  std::unique_ptr<Timer> recovery_timer;

  bool listens() const { return attached && !off; }

  /// False: the node refuses the frame.
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
