// A simulated CAN bus in virtual time: the identifier decides arbitration, and the transmission of a frame
// takes the time of its bits.
//
// The simulation runs as fast as the computer can, and its results are reproducible to the bit. One
// VirtualClock (virtual_clock.h) drives any number of nodes. A node uses a SimBus through the class `Bus`,
// like a SocketCAN interface.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "can/bus.h"
#include "can/frame_bits.h"
#include "can/sim/virtual_clock.h"

namespace hystcan::can {

namespace sim {
class Wire;
struct Node;
}  // namespace sim

/// Numbers of bits during and after an error frame (ISO 11898-1). Nodes that detect an error at the same bit
/// send their error flags together. A node that detects only the error flag of another node sends its own
/// flag later, so that the flags take up to 12 bits.
inline constexpr unsigned error_flag_bits = 6;
inline constexpr unsigned error_flags_max_bits = 12;
inline constexpr unsigned error_delimiter_bits = 8;
inline constexpr unsigned suspend_bits = 8;  ///< pause of an error-passive node after its transmission

/// Bus-off ends after `recovery_sequences` sequences of `recovery_sequence_bits` recessive bits.
inline constexpr unsigned recovery_sequences = 128;
inline constexpr unsigned recovery_sequence_bits = 11;

/// The order in which a node transmits its queued frames. `as_sent`: first in, first out, like the queue of a
/// SocketCAN interface. `by_priority`: highest priority first, like a CAN controller with several transmit
/// buffers.
enum class TransmitOrder : std::uint8_t { as_sent, by_priority };

/// The simulated faults of one node; each member is a probability 0..1. If an error-active node detects an
/// error, the frame is destroyed for all nodes, and the sender repeats the frame. If only an error-passive
/// receiver detects an error, only this receiver misses the frame.
struct NodeFaults {
  double transmit_bit_error = 0.0;  ///< probability of an error in each bit that the node sends
  double receive_bit_error = 0.0;   ///< probability of an error in each bit that the node receives
  double overrun = 0.0;  ///< probability that the node acknowledges a frame but loses it, because its receive
                         ///< buffer is full
};

struct SimBusConfig {
  double bit_error = 0.0;  ///< probability per bit of an error that all nodes detect together, 0..1
  std::uint64_t seed = 1;
  std::optional<Duration> restart_after;  ///< time from bus-off to the automatic restart request; nullopt: no
                                          ///< automatic restart
};

/// The connection of a node to a simulated bus. Its state, counters and error counters follow ISO 11898-1, as
/// with a SocketCAN driver that reports errors. The destructor detaches the node, which then neither sends
/// nor receives. The queued frames of the node are lost; a frame that is already on the wire is still
/// delivered.
class SimNode final : public Bus {
 public:
  SimNode(std::shared_ptr<sim::Wire> wire, TransmitOrder order, std::span<const Filter> filters);
  ~SimNode() override;
  SimNode(const SimNode&) = delete;
  SimNode& operator=(const SimNode&) = delete;

  bool send(const Frame& frame) override;
  void on_frame(FrameHandler handler) override;
  bool on_sent(FrameHandler handler) override;
  void on_state(StateHandler handler) override;
  BusState state() const override;
  std::optional<ErrorCounters> error_counters() const override;
  const BusCounters& counters() const override;

  /// Sets the simulated faults of this node. Throws std::invalid_argument if a probability is not within
  /// 0..1.
  void set_faults(const NodeFaults& faults);
  /// Requests the end of bus-off. The node takes part in the bus again after 128 times 11 recessive bits,
  /// with its error counters at 0.
  void restart();

 private:
  std::shared_ptr<sim::Wire> wire_;
  sim::Node& node_;
};

/// The simulated bus. When the wire is idle, the attached node whose waiting frame has the lowest identifier
/// wins arbitration, as on a real bus: a standard frame wins against an extended frame with the same first 11
/// bits, and a data frame wins against a remote frame. Frames that nodes send at the same instant take part
/// in one arbitration. After its last bit, a frame reaches every other node whose filters pass the frame.
///
/// The transmission of a frame stops at the bit of an error. An error frame of 14 to 20 bits and the
/// interframe space follow; then the frame takes part in arbitration again. The same happens if no other node
/// acknowledges the frame. An error in the data phase of an FD frame ends this phase: the error frame uses
/// the nominal bit rate. A node that becomes bus-off loses its queued frames.
///
/// The simulation does not include errors in the last bit of a frame, which receivers and sender treat
/// differently. If two nodes send the same identifier at the same instant, the node that was attached first
/// wins.
class SimBus {
 public:
  /// Queue length of one node in frames, equal to the default of a SocketCAN interface. If the queue is full,
  /// SimNode::send() returns false.
  static constexpr std::size_t transmit_queue_length = 10;

  /// Throws std::invalid_argument if the nominal bit rate is 0 or a probability is not within 0..1.
  SimBus(VirtualClock& clock, const BitRates& rates, const SimBusConfig& config = {});
  ~SimBus();

  /// Attaches a node to the bus. The node receives the frames that its filters pass; without filters, the
  /// node receives every frame.
  std::unique_ptr<SimNode> attach(TransmitOrder order = TransmitOrder::as_sent,
                                  std::span<const Filter> filters = {});

  /// Sets the probability per bit of an error that all nodes detect. The next frame is the first frame with
  /// this probability. Throws std::invalid_argument if the probability is not within 0..1.
  void set_bit_error(double probability);

  /// Returns the bus load since the start, 0..1: the time in which the wire was busy, divided by the elapsed
  /// time.
  double load() const;

 private:
  std::shared_ptr<sim::Wire> wire_;
};

}  // namespace hystcan::can
