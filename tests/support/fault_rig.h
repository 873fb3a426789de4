// A controller and a twin, or nodes on a simulated card, on the simulated bus. A test begins and ends any
// number of troubles while the loop runs. A trouble of a node is a fault of the twin (twin/fault.h) if the
// twin has it. The other troubles act on the connections and on the controller's scheduler; a tester sends
// frames of other nodes. A WireMonitor for each axis receives every frame.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/card_nodes.h"
#include "tests/support/hooked_connection.h"
#include "tests/support/oversleeper.h"
#include "tests/support/wire_monitor.h"

namespace hystcan::support {

enum class Trouble : std::uint8_t {
  sample_lost,
  sample_late,     ///< each sample arrives when the next one is due
  sample_frozen,   ///< the value is constant, the counters run
  counter_frozen,  ///< the message counter is constant, so that the message is rejected
  sample_jumped,   ///< the position is wrong by 8 um, from one sample to the next
  sample_beyond,   ///< the position is 60 um, beyond position_max_um
  sample_bad,      ///< the signal Status of the sample is nonzero
  sample_damaged,  ///< the CRC is wrong
  sensor_emergency,
  sensor_unheard,     ///< the sensor's heartbeats are lost, but not its samples
  amplifier_unheard,  ///< the amplifier's heartbeats and statuses are lost
  sensor_stopped,     ///< another node stops the sensor by NMT
  amplifier_stopped,
  sensor_leaves,  ///< the sensor leaves the state operational by itself, which its heartbeats show
  sensor_reset,   ///< the sensor restarts after a supply failure
  amplifier_reset,
  amplifier_trips,  ///< the amplifier trips because of an internal cause
  commands_lost,    ///< commands do not reach the amplifier, whose watchdog trips
  enable_lost,      ///< the amplifier disables itself
  bus_passive,
  bus_off,
  interface_down,
  position_drifts,  ///< the position drifts by 1 um per cycle, up to 7.5 um: the stage leaves the reference
  load_pulls,       ///< a load pulls by 0.05 um per cycle, up to 7 um: no drive reaches the reference
  sync_late,        ///< each SYNC is late by half a cycle
  stall,            ///< one SYNC is late by 20 cycles
  foreign_sync,
  foreign_heartbeat,
  foreign_write,   ///< another node writes to the amplifier by SDO
  forged_sample,   ///< an additional sample, off by 1 um, before each sample of the sensor
  statuses_lost,   ///< the amplifier's statuses are lost, but not its heartbeats
  law_not_finite,  ///< a gain becomes NaN
};
inline constexpr std::size_t trouble_count = 32;
std::string_view to_string(Trouble trouble);
inline void PrintTo(Trouble trouble, std::ostream* out) { *out << to_string(trouble); }

/// Maximum time from the frame that decides a fault to the safe command, at 1 kHz and 1 Mbit/s
/// (docs/safety.md). In the worst case the command waits for a frame on the wire, and for an emergency of
/// each node, a status and a sample, which have a higher priority. If a fault is decided between two control
/// steps, the next step sends the command: at the next sample, or at the following SYNC if that sample is
/// lost.
inline constexpr double frame_ms = 0.135;  ///< duration of an eight-byte frame with all stuff bits
inline constexpr double safe_in_a_step_ms = 6 * frame_ms;
inline constexpr double safe_between_steps_ms = 2.0 + safe_in_a_step_ms;
/// Returns true if a fault with this cause is decided between two control steps.
bool is_between_steps(controller::Cause cause);

/// Returns the shipped piezo axis x alone, with a slow sine, a quick start-up and all supervision enabled.
config::Config one_axis();
/// Returns the axis of one_axis() with its amplifier and sensor on a simulated card.
config::Config one_axis_on_a_card();
/// Returns the axes of fd_stage.toml, which share their frames and nodes, with the changes of one_axis().
config::Config two_axes_in_a_frame();

/// Returns the limits that the frames of an axis must keep.
WireMonitor::Config monitor_config(const config::Config& config, std::size_t index = 0);

class FaultRig {
 public:
  explicit FaultRig(const config::Config& config);

  void start();
  void run_for(can::Duration time);
  /// Runs until the axis is in `state`. Returns false if that takes longer than `limit`.
  bool reaches(controller::AxisState state, can::Duration limit);
  bool tracks(can::Duration limit = std::chrono::seconds(5)) {
    return reaches(controller::AxisState::tracking, limit);
  }

  void begin(Trouble trouble);
  void end(Trouble trouble);
  bool is_on(Trouble trouble) const { return on_[static_cast<std::size_t>(trouble)]; }

  /// Sends the request by RequestLink, as `hystcan ctl` does. Returns the reason for a refusal, or an empty
  /// text.
  std::string_view ask(controller::Request::Kind kind, std::size_t axis = 0);
  std::string_view retune(const controller::AxisConfig& next);

  const controller::Axis& axis(std::size_t index = 0) const {
    return std::as_const(*controller_).axis(index);
  }
  controller::Controller& controller() { return *controller_; }
  twin::FaultTarget stage();
  twin::FaultScheduler& stage_faults() { return twin_ ? twin_->faults() : card_nodes_->faults(); }
  FaultyCard& card() { return card_nodes_->card(); }
  can::VirtualClock& clock() { return clock_; }
  WireMonitor& monitor() { return monitors_[0]; }
  const WireMonitor& monitor(std::size_t axis = 0) const { return monitors_[axis]; }
  const config::Config& config() const { return config_; }
  void send(const can::Frame& frame) { tester_->send(frame); }
  /// Attaches another node, which receives every frame while the returned object exists.
  std::unique_ptr<can::Bus> listen(std::function<void(const can::Frame&)> handler);

  /// Number of faults of the first axis.
  std::uint64_t faults() const { return faults_; }
  /// Returns when the last fault of the first axis was decided: at the end of the frame that shows it, or at
  /// the SYNC by which the controller detects it.
  can::Time decided_at() const { return decided_at_; }

 private:
  void interrupt_supply(twin::Node node);
  void end_twin_faults(Trouble trouble);
  std::unique_ptr<can::Bus> attach_node(std::span<const can::Filter> filters);
  void note_fault(can::Time when);
  bool sensor_sends(can::Frame& frame);
  void displace(can::Frame& sample);
  std::string_view run_until_answered(std::unique_ptr<controller::Request> request);

  config::Config config_;
  std::array<bool, trouble_count> on_{};
  can::VirtualClock clock_;
  can::SimBus bus_{clock_, config_.bus.rates()};
  Oversleeper sleeper_{clock_};
  std::vector<WireMonitor> monitors_;  ///< one for each axis
  std::unique_ptr<can::Bus> monitor_bus_;
  std::unique_ptr<can::Bus> tester_;
  controller::RequestLink requests_;
  std::unique_ptr<twin::Twin> twin_;       ///< null: the axis is on a card
  std::unique_ptr<CardNodes> card_nodes_;  ///< null: the axis has a twin
  can::SimNode* controller_node_ = nullptr;
  HookedConnection* controller_connection_ = nullptr;
  std::unique_ptr<controller::Controller> controller_;
  double offset_um_ = 0.0;
  std::vector<bool> was_faulted_;  ///< one for each axis
  std::uint64_t faults_ = 0;
  can::Time decided_at_{};
};

}  // namespace hystcan::support
