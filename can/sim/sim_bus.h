// A CAN bus in virtual time: arbitration by identifier, frames that take as long as their bits do.
//
// Runs as fast as the machine can and is reproducible to the bit. One VirtualClock drives any number of
// nodes; each node attaches to a SimBus and gets the same `Bus` that SocketCAN gives it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "can/bus.h"

namespace hystcan::can {

namespace sim {
class Wire;
}

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

/// Bits of an error frame and after it (ISO 11898-1). The flags of nodes that see an error at the same bit
/// lie upon each other; a node that only sees its neighbour's flag adds its own six bits to it.
inline constexpr unsigned error_flag_bits = 6;
inline constexpr unsigned error_flags_max_bits = 12;
inline constexpr unsigned error_delimiter_bits = 8;
inline constexpr unsigned suspend_bits = 8;  ///< an error-passive node's pause after it has transmitted

/// Bus-off ends after so many times so many recessive bits.
inline constexpr unsigned recovery_sequences = 128;
inline constexpr unsigned recovery_sequence_bits = 11;

/// In which order a node's frames leave it: as they were sent, as from the queue of a SocketCAN interface; or
/// the most urgent first, as from a CAN controller with several transmit buffers.
enum class TransmitOrder : std::uint8_t { as_sent, by_priority };

/// What goes wrong at one node, each a probability 0..1. Whatever destroys a frame for one error-active node
/// destroys it for all, and it is sent again. An error-passive receiver that alone sees an error misses the
/// frame.
struct NodeFaults {
  double transmit_bit_error = 0.0;  ///< per bit that it sends
  double receive_bit_error = 0.0;   ///< per bit that it hears
  double overrun = 0.0;             ///< per frame: acknowledged, then lost in the node's full receive buffer
};

struct SimBusConfig {
  double bit_error = 0.0;  ///< probability per bit that all nodes see an error
  std::uint64_t seed = 1;
  std::optional<Duration> restart_after;  ///< from bus-off to the automatic restart request; empty: none
};

/// A node's connection to a simulated bus. Its state, counters and error counters follow ISO 11898-1, as a
/// SocketCAN driver with error reporting would tell them.
class SimNode : public Bus {
 public:
  /// Throws std::invalid_argument where a probability is not within 0..1.
  virtual void set_faults(const NodeFaults& faults) = 0;
  /// Where the node is bus-off: it comes back after 128 times 11 recessive bits, its counters at 0.
  virtual void restart() = 0;
};

/// The wire. Idle: the attached node with the lowest pending identifier wins, as the bits decide: standard
/// beats extended of the same base, data beats remote. Frames sent at the same instant arbitrate. The frame
/// reaches every other node when its last bit has passed.
///
/// A frame that meets an error ends there: an error frame of 14 to 20 bits and the interframe space follow,
/// and it arbitrates again. So does one that nobody acknowledges because there is no other node. At bus-off a
/// node loses what it has queued. Not modelled: errors in the last bit of a frame, which receivers and
/// sender see differently; two nodes that send one identifier at one instant (the one attached first wins).
class SimBus {
 public:
  /// Of one node, as a SocketCAN interface has it where nobody sets txqueuelen; a frame sent into a full
  /// queue is refused, as ENOBUFS would.
  static constexpr std::size_t transmit_queue_length = 10;

  /// Throws std::invalid_argument: bit rate 0, a probability not within 0..1.
  SimBus(VirtualClock& clock, std::uint32_t bitrate_bit_per_s, const SimBusConfig& config = {});
  ~SimBus();

  /// A node's connection. Destroying it detaches the node: it neither sends nor receives from then on; what
  /// it has queued is lost, a frame already on the wire is not.
  std::unique_ptr<SimNode> attach(TransmitOrder order = TransmitOrder::as_sent);

  /// From the next frame on. Throws std::invalid_argument.
  void set_bit_error(double probability);

  /// Share of the elapsed time in which the wire was busy, 0..1.
  double load() const;

 private:
  class Port;
  std::shared_ptr<sim::Wire> wire_;
};

}  // namespace hystcan::can
