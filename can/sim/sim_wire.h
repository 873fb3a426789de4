// The wire of the simulated bus: which node sends next, for how long, and which nodes receive the frame.
// Internal to the simulated bus.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "can/sim/sim_fate.h"
#include "can/sim/sim_node.h"
#include "can/sim/sim_recovery.h"

namespace hystcan::can::sim {

class Wire : public std::enable_shared_from_this<Wire> {
 public:
  Wire(VirtualClock& clock, std::uint32_t bitrate_bit_per_s, const SimBusConfig& config);

  Node& attach(TransmitOrder order);
  void detach(Node& node);
  /// A node has a frame to send. All nodes that send at this instant take part in the arbitration.
  void contend();
  void request_restart(Node& node);
  void note_faults() { disturbance_.note_faults(nodes_); }
  void set_bit_error(double probability);
  double load() const;

 private:
  void arbitrate();
  void await_suspended();
  void count_losers(const Node& winner);

  void finish();
  void deliver(std::size_t present);
  bool misses(Node& node);
  void destroy(std::size_t present);
  void count_sender_error(Node& node);
  void suspend_if_passive(Node& node);
  static void count_error(Node& node);
  static void report_state(Node& node);

  void on_recovery_timer(Node& node);
  void remove_detached();
  Duration duration_of(unsigned bits) const;

  VirtualClock& clock_;
  double bit_ns_;
  Time start_;
  Time free_at_;  ///< end of the interframe space after the latest frame
  Duration busy_{};
  Disturbance disturbance_;
  BusOffRecovery recovery_;
  std::vector<std::unique_ptr<Node>> nodes_;
  Frame frame_;  ///< the one on the wire
  Fate fate_;
  Node* sender_ = nullptr;
  bool on_wire_ = false;
  bool contending_ = false;
  bool calling_handlers_ = false;
  bool any_detached_ = false;
  std::unique_ptr<Timer> timer_;
};

}  // namespace hystcan::can::sim
