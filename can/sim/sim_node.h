// One node of the simulated bus: its transmit queue, its fault confinement and its recovery from bus-off.
// Only for use within can/sim.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "can/bus.h"
#include "can/sim/sim_bus.h"

namespace hystcan::can::sim {

/// Fault confinement of one CAN node (ISO 11898-1, 10.11): its transmit error counter (TEC), its receive
/// error counter (REC) and the resulting state. These events change the counters:
///
///   transmit error               TEC + 8     unchanged if an error-passive node receives no acknowledgement
///   receive error                REC + 1
///   dominant bit after           REC + 8     only for the receiver that detected the error before all others
///     its own error flag
///   frame transmitted            TEC - 1     not below 0
///   frame received               REC - 1     not below 0; from 128 or more to 119
///
/// The counters determine the state:
///
///   warning                      TEC >= 96 or REC >= 96
///   passive                      TEC >= 128 or REC >= 128
///   bus-off                      TEC >= 256
class FaultConfinement {
 public:
  static constexpr std::uint16_t warning_limit = 96;
  static constexpr std::uint16_t passive_limit = 128;
  static constexpr std::uint16_t bus_off_limit = 256;

  void transmitted() {
    if (counters_.transmit != 0) --counters_.transmit;
  }
  void received() {
    if (counters_.receive >= passive_limit) {
      counters_.receive = receive_after_passive;
    } else if (counters_.receive != 0) {
      --counters_.receive;
    }
  }
  void transmit_error() { counters_.transmit = static_cast<std::uint16_t>(counters_.transmit + 8); }
  void not_acknowledged() {
    if (counters_.transmit < passive_limit) transmit_error();
  }
  void receive_error() { add_to_receive(1); }
  void dominant_after_error_flag() { add_to_receive(8); }
  void restart() { counters_ = {}; }

  bool passive() const { return std::max(counters_.transmit, counters_.receive) >= passive_limit; }
  bool bus_off() const { return counters_.transmit >= bus_off_limit; }
  BusState state() const {
    const std::uint16_t worse = std::max(counters_.transmit, counters_.receive);
    if (bus_off()) return BusState::bus_off;
    if (worse >= passive_limit) return BusState::passive;
    return worse >= warning_limit ? BusState::warning : BusState::active;
  }
  const ErrorCounters& counters() const { return counters_; }

 private:
  /// New value of the receive error counter after an error-passive node received a frame. The standard allows
  /// 119 to 127.
  static constexpr std::uint16_t receive_after_passive = 119;
  static constexpr std::uint16_t receive_max = 255;  ///< the receive error counter has eight bits

  void add_to_receive(std::uint16_t errors) {
    counters_.receive = std::min(receive_max, static_cast<std::uint16_t>(counters_.receive + errors));
  }

  ErrorCounters counters_;
};

inline constexpr std::uint32_t never = 0xFFFF'FFFF;

inline std::uint32_t arbitration_key(const Frame& frame) {
  return can::arbitration_key(frame.id, frame.extended, frame.kind == FrameKind::remote);
}

inline bool can_be_sent(const Frame& frame) {
  if (!is_identifier(frame.id, frame.extended) || frame.kind == FrameKind::error) return false;
  return frame.length <= (frame.kind == FrameKind::fd ? frame.data.size() : 8);
}

/// The recovery of a node from bus-off: the node is `waiting` for the restart request, then `counting` the
/// recessive bits on the bus.
enum class Recovery : std::uint8_t { none, waiting, counting };

struct Node {
  Node(std::size_t attached_as, TransmitOrder transmit_order, std::span<const Filter> receives)
      : number(attached_as), order(transmit_order), filters(receives.begin(), receives.end()) {}

  const std::size_t number;  ///< number of nodes that were attached before this node
  const TransmitOrder order;
  const std::vector<Filter> filters;
  Bus::FrameHandler on_frame;
  Bus::FrameHandler on_sent;
  Bus::StateHandler on_state;
  std::uint32_t key = never;  ///< arbitration field of the frame to send next; the lowest field wins
  Time suspended_until;       ///< end of the pause after a transmission, if the node is error-passive
  BusCounters counters;
  std::array<Frame, SimBus::transmit_queue_length> queue;
  std::size_t oldest = 0;
  std::size_t queued = 0;
  Frame returned;  ///< the frame that was destroyed on the wire and is sent again, if sends_again
  bool sends_again = false;
  bool attached = true;
  bool off = false;     ///< the node is in bus-off
  bool missed = false;  ///< the node is error-passive and detected an error in the frame on the wire
  FaultConfinement confinement;
  BusState reported = BusState::active;  ///< the last state that was passed to on_state
  NodeFaults faults;
  Recovery recovery = Recovery::none;
  unsigned sequences_left = 0;  ///< sequences of 11 recessive bits that are still needed for the recovery
  Time recessive_since;
  std::unique_ptr<Timer> recovery_timer;

  bool listens() const { return attached && !off; }
  /// Returns true if a filter passes the frames of this identifier, or if the node has no filters.
  bool receives(std::uint32_t id) const {
    return filters.empty() || std::ranges::find(filters, id, &Filter::id) != filters.end();
  }

  /// Puts a frame into the transmit queue. Returns false if the queue is full, the node is in bus-off, or the
  /// frame is invalid.
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
