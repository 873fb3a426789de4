// A CAN bus in virtual time: the identifier decides arbitration, and a frame takes the time of its bits.
//
// The simulation runs as fast as the machine can, and its results are reproducible to the bit. One
// VirtualClock (virtual_clock.h) drives any number of nodes. Each node attaches to a SimBus and gets the same
// interface, `Bus`, as from SocketCAN.
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

/// Bits during and after an error frame (ISO 11898-1). The flags of nodes that detect an error at the same
/// bit overlap. A node that detects only the flag of another node adds its own six bits.
inline constexpr unsigned error_flag_bits = 6;
inline constexpr unsigned error_flags_max_bits = 12;
inline constexpr unsigned error_delimiter_bits = 8;
inline constexpr unsigned suspend_bits = 8;  ///< pause of an error-passive node after it has transmitted

/// Bus-off ends after `recovery_sequences` sequences of `recovery_sequence_bits` recessive bits.
inline constexpr unsigned recovery_sequences = 128;
inline constexpr unsigned recovery_sequence_bits = 11;

/// The order in which frames leave a node. `as_sent` is the order of the queue of a SocketCAN interface.
/// `by_priority` is the order of a CAN controller with several transmit buffers.
enum class TransmitOrder : std::uint8_t { as_sent, by_priority };

/// The faults of one node, each a probability 0..1. An error at one error-active node destroys the frame for
/// all nodes, and the sender repeats it. If only an error-passive receiver detects an error, only this
/// receiver misses the frame.
struct NodeFaults {
  double transmit_bit_error = 0.0;  ///< probability per bit that the node sends
  double receive_bit_error = 0.0;   ///< probability per bit that the node receives
  double overrun = 0.0;  ///< probability per frame that the node acknowledges the frame but loses it, because
                         ///< its receive buffer is full
};

struct SimBusConfig {
  double bit_error = 0.0;  ///< probability per bit that all nodes detect an error
  std::uint64_t seed = 1;
  std::optional<Duration> restart_after;  ///< time from bus-off to the automatic restart request; nullopt: no
                                          ///< automatic restart
};

/// The connection of a node to a simulated bus. Its state, counters and error counters follow ISO 11898-1,
/// like those of a SocketCAN driver with error reporting. The destructor detaches the node, which then
/// neither sends nor receives. Its queued frames are lost; a frame that is already on the wire is not.
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

  /// Throws std::invalid_argument if a probability is not within 0..1.
  void set_faults(const NodeFaults& faults);
  /// Ends bus-off: the node restarts after 128 times 11 recessive bits, with its counters at 0.
  void restart();

 private:
  std::shared_ptr<sim::Wire> wire_;
  sim::Node& node_;
};

/// The wire. When it is idle, the attached node with the lowest pending identifier wins, as on a real bus:
/// standard before extended with the same base, data before remote. Frames sent at the same instant take part
/// in one arbitration. A frame reaches every other node whose filters pass it after its last bit.
///
/// A frame ends at the bit of an error. An error frame of 14 to 20 bits and the interframe space follow; then
/// the frame takes part in arbitration again. The same happens if no other node acknowledges the frame. An
/// error in the data phase of an FD frame ends the phase: the error frame uses the nominal bit rate. A node
/// that becomes bus-off loses its queued frames.
///
/// The model does not include errors in the last bit of a frame, which receivers and sender treat
/// differently. If two nodes send the same identifier at the same instant, the node that was attached first
/// wins.
class SimBus {
 public:
  /// Queue length of one node, equal to the default of a SocketCAN interface. If the queue is full, the bus
  /// refuses the frame, like ENOBUFS.
  static constexpr std::size_t transmit_queue_length = 10;

  /// Throws std::invalid_argument if the nominal bit rate is 0 or a probability is not within 0..1.
  SimBus(VirtualClock& clock, const BitRates& rates, const SimBusConfig& config = {});
  ~SimBus();

  /// The node receives the frames that its filters pass; without filters, it receives every frame.
  std::unique_ptr<SimNode> attach(TransmitOrder order = TransmitOrder::as_sent,
                                  std::span<const Filter> filters = {});

  /// Applies from the next frame on. Throws std::invalid_argument if the probability is not within 0..1.
  void set_bit_error(double probability);

  /// The fraction of the elapsed time in which the wire was busy, 0..1.
  double load() const;

 private:
  std::shared_ptr<sim::Wire> wire_;
};

}  // namespace hystcan::can
