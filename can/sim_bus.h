// A CAN bus in virtual time: arbitration by identifier, frames that take as long as their bits do.
//
// Runs as fast as the machine can and is reproducible to the bit. One VirtualClock drives any number of
// nodes; each node attaches to a SimBus and gets the same `Bus` that SocketCAN gives it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "can/bus.h"

namespace hystcan::can {

/// Discrete-event scheduler: events at the same instant run in the order in which they were armed.
class VirtualClock final : public Scheduler {
 public:
  VirtualClock();
  ~VirtualClock() override;

  Time now() const override;
  std::unique_ptr<Timer> make_timer(std::function<void()> on_expiry) override;

  /// Runs every event up to and including `end`, then stands at `end`. A deadline that has passed already is
  /// due now. Not to be called from within an event.
  void run_until(Time end);

 private:
  class Queue;
  class Alarm;
  std::shared_ptr<Queue> queue_;  ///< timers may outlive the clock; they never go off then
};

/// Bits of interframe space after every frame (ISO 11898-1).
inline constexpr unsigned interframe_bits = 3;

/// Bits that `frame` occupies on the wire: start of frame to end of frame with the stuff bits its content
/// needs, and the interframe space. An FD frame counts as one sent without a switch of bit rate.
unsigned frame_bits(const Frame& frame);

/// The wire. Idle: the attached node with the lowest pending identifier wins, as the bits decide: standard
/// beats extended of the same base, data beats remote. Frames sent at the same instant arbitrate; one node's
/// frames leave in the order in which they were sent. The frame reaches every other node when its last bit
/// has passed.
class SimBus {
 public:
  /// Queue of one node's controller; a frame sent into a full queue is refused, as ENOBUFS would.
  static constexpr std::size_t transmit_queue_length = 8;

  SimBus(VirtualClock& clock, std::uint32_t bitrate_bit_per_s);
  ~SimBus();

  /// A node's connection. Destroying it detaches the node: it neither sends nor receives from then on; what
  /// it has queued is lost, a frame already on the wire is not.
  std::unique_ptr<Bus> attach();

  /// Share of the elapsed time in which the wire was busy, 0..1.
  double load() const;

 private:
  class Port;
  struct Wire;
  std::shared_ptr<Wire> wire_;
};

}  // namespace hystcan::can
