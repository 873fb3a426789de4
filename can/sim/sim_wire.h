// The wire of the simulated bus: decides which node sends next, how long the transmission takes, and which
// nodes receive the frame. Only for use within can/sim.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <unordered_map>
#include <vector>

#include "can/sim/sim_node.h"

namespace hystcan::can::sim {

/// The transmission of one frame: how it ends, and how many bits it takes.
struct Transmission {
  enum class End : std::uint8_t { delivered, not_acknowledged, destroyed };
  End end = End::delivered;
  BitCount bits;                  ///< bits from the start of the frame to the end of the interframe space
  const Node* witness = nullptr;  ///< the node that detected the error before all other nodes; null if all
                                  ///< nodes detected the error at the same bit
};

using Nodes = std::span<const std::unique_ptr<Node>>;

/// Simulates random bit errors. Each bit of a frame has an error with a given probability, either for all
/// nodes or for one node. The first error ends the transmission.
class Disturbance {
 public:
  /// `bit_error`: the probability per bit of an error that all nodes detect together.
  Disturbance(double bit_error, std::uint64_t seed) : bit_error_(bit_error), random_(seed) {}

  void set_bit_error(double probability) { bit_error_ = probability; }
  /// Updates is_active(). Call when the faults of a node change, or when a node is detached.
  void note_faults(Nodes nodes);
  /// Returns true if at least one probability of an error is above 0.
  bool is_active() const { return is_active_; }

  /// Decides at random how the transmission of a frame ends. Sets Node::missed for each error-passive node
  /// that alone detects an error: this node then misses the frame.
  Transmission draw(const Frame& frame, const Node& sender, Nodes nodes);
  /// Decides at random if this node loses the frame because its receive buffer is full; returns true if so.
  bool overruns(const Node& node) { return node.faults.overrun > 0.0 && uniform() < node.faults.overrun; }

 private:
  std::optional<Transmission> error_within(const FrameBits& frame, unsigned bits, const Node& sender,
                                           Nodes nodes);
  unsigned first_error(double per_bit, unsigned none);
  unsigned dominant_bits_before_flag();
  double uniform() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }

  double bit_error_;
  std::mt19937_64 random_;
  bool is_active_ = false;
};

/// The nodes that receive the frames of each identifier, in the order of attachment.
class Receivers {
 public:
  void add(Node& node);
  void remove(Node& node);
  const std::vector<Node*>& of(std::uint32_t id) const {
    const auto found = filtered_.find(id);
    return found == filtered_.end() ? unfiltered_ : found->second;
  }

 private:
  std::vector<Node*> unfiltered_;                                   ///< nodes that receive every frame
  std::unordered_map<std::uint32_t, std::vector<Node*>> filtered_;  ///< for each identifier in a filter, the
                                                                    ///< nodes that receive its frames
};

class Wire : public std::enable_shared_from_this<Wire> {
 public:
  Wire(VirtualClock& clock, const BitRates& rates, const SimBusConfig& config);

  Node& attach(TransmitOrder order, std::span<const Filter> filters);
  void detach(Node& node);
  /// Puts a frame into the queue of a node. Returns false if Node::push() refuses the frame. The frames that
  /// all nodes send at the same instant take part in one arbitration.
  bool send(Node& node, const Frame& frame);
  void request_restart(Node& node);
  void note_faults() { disturbance_.note_faults(nodes_); }
  void set_bit_error(double probability);
  double load() const;

 private:
  void note_pending(Node& node);
  void contend();
  void arbitrate();
  void await_suspended();
  void count_losers(const Node& winner);

  void finish();
  void deliver(std::size_t present);
  void deliver_and_count_errors(std::size_t present);
  void pass_to(Node& node);
  bool misses(Node& node);
  void destroy(std::size_t present);
  void count_sender_error(Node& node);
  void suspend_if_passive(Node& node);
  static void count_error(Node& node);
  static void report_state(Node& node);

  void go_off(Node& node);
  void on_recovery_timer(Node& node);
  void expect_recessive(Node& node, Time since) const;
  void count_recessive_bits();
  void add_recessive_end();
  void come_back(Node& node);
  void remove_detached();
  Duration duration_of(const BitCount& bits) const;

  VirtualClock& clock_;
  double bit_ns_;       ///< duration of a bit at the nominal bit rate
  double data_bit_ns_;  ///< duration of a bit in the data phase of CAN FD
  Time start_;
  Time free_at_;  ///< end of the interframe space after the latest frame
  Duration busy_{};
  Disturbance disturbance_;
  /// Time from bus-off to the automatic restart request; nullopt: no automatic restart.
  std::optional<Duration> restart_after_;
  std::size_t nodes_off_ = 0;  ///< number of nodes in bus-off
  std::vector<std::unique_ptr<Node>> nodes_;
  Receivers receivers_;
  std::vector<Node*> pending_;  ///< the nodes with a frame to send
  std::size_t attached_ = 0;    ///< number of nodes attached since the start
  Frame frame_;                 ///< the frame on the wire
  Transmission transmission_;   ///< how the transmission of frame_ ends
  Node* sender_ = nullptr;
  bool on_wire_ = false;
  bool contending_ = false;
  bool calling_handlers_ = false;
  bool any_detached_ = false;
  bool any_receive_error_ = false;  ///< if false, every receive error counter is 0; a delivery changes none
  std::unique_ptr<Timer> timer_;
};

}  // namespace hystcan::can::sim
