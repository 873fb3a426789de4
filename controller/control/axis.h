// One axis: supervisor, gate, and what decides the drive: in closed loop a ClosedLoop, in open loop an
// Excitation. A pure step: takes the time and the received data; returns a command.
//
//   offline -> waiting -> initialising -> ready -> tracking      and from any state but offline to faulted
//
//   waiting       StartUp: the axis waits until both nodes are operational, the amplifier ready and at rest
//   initialising  StartUp: the drive ramps to where tracking begins. In closed loop it goes up to the upper
//                 threshold and down to the lower one: this wipes the actuator's memory out, and the model's
//                 memory agrees with it. In open loop it goes straight to the first drive of the excitation
//   ready         the axis holds that drive until the axes begin together, or follows those that track
//   tracking      the closed loop follows its reference, the open loop its excitation
//   faulted       Fall: the fault is latched with cause and time
#pragma once

#include <optional>

#include "controller/control/axis_config.h"
#include "controller/control/axis_report.h"
#include "controller/control/course.h"
#include "controller/control/fall.h"
#include "controller/control/loop.h"
#include "controller/control/oscillation.h"
#include "controller/control/output_check.h"
#include "controller/control/refusal.h"
#include "controller/control/start_up.h"
#include "controller/control/supervisor.h"

namespace hystcan::controller {

/// A new configuration for a running axis; built outside the control thread.
struct AxisTuning {
  /// `new_reference`: the setpoint has changed; otherwise the present reference continues.
  AxisTuning(const AxisConfig& next, bool new_reference);
  AxisConfig config;
  std::optional<Trajectory> reference;
  std::optional<Learning> learning;
};

class Axis {
 public:
  /// Throws std::invalid_argument where the model is invalid, or the excitation exceeds the gate's limits.
  explicit Axis(const AxisConfig& config);

  /// Leaves offline towards tracking. `clear_amplifier_fault`: with one attempt to clear a fault that is
  /// latched in the amplifier.
  void start(bool clear_amplifier_fault);
  /// Ramps to the safe drive, then switches the amplifier off and goes offline.
  void stop() { stopping_ = true; }
  /// Clears a fault and goes offline; the next start attempts once to clear the amplifier's.
  std::optional<Refusal> clear();
  void trip(Cause cause, double time_s);

  /// Live setpoint: moves smoothly to this position and stays there. Refused where the axis does not track a
  /// reference, where the position is outside position_min_um..position_max_um, or where it is beyond what
  /// the model reaches at its thresholds. Allocates nothing.
  std::optional<Refusal> go_to(double position_um);
  /// Ends a live setpoint: follows the configured reference again.
  std::optional<Refusal> resume();

  /// Called between two cycles: changes everything but the model, and leaves the former configuration in
  /// `tuning`.
  std::optional<Refusal> retune(AxisTuning& tuning);

  /// The law whose memory is to be saved after a clean stop. Null: the memory is unknown, or there is none.
  const ControlLaw* law_to_save() const;
  /// Called before the first start with the saved memory. Sets it only where start-up is `restore`.
  void restore(const model::HysteresisState& memory);
  /// Null in open loop.
  ClosedLoop* closed_loop() { return closed_loop_ ? &*closed_loop_ : nullptr; }
  const ClosedLoop* closed_loop() const { return closed_loop_ ? &*closed_loop_ : nullptr; }

  /// The reference at that reference time; the last measured position where the axis does not track a
  /// reference.
  double expected_um(double time_s) const;

  /// The point of the reference at that reference time; empty where the axis does not track a reference.
  std::optional<Trajectory::Point> reference_at(double time_s) const;

  /// Called exactly once per cycle.
  AxisCommand step(const AxisInput& input);

  AxisState state() const { return state_; }
  /// A sample and a command are expected in every cycle.
  bool is_in_use() const { return controller::is_in_use(state_) || fall_.state() == Fall::State::ramping; }
  const Fault& fault() const { return fall_.fault(); }
  const AxisReport& report() const { return report_; }
  const AxisConfig& config() const { return config_; }

 private:
  AxisCommand supervise(const AxisInput& input);
  AxisInput examine(const AxisInput& input);
  AxisCommand decide(const AxisInput& input);
  AxisCommand start_up(const AxisInput& input);
  AxisCommand hold_ready(const AxisInput& input);
  AxisCommand track(const AxisInput& input);
  AxisCommand park(const AxisInput& input);
  ClosedLoop* loop_for_live_setpoints();

  AxisConfig config_;
  std::optional<ClosedLoop> closed_loop_;  ///< one of the two
  std::optional<Excitation> excitation_;
  StartUp start_up_;
  Fall fall_;
  Supervisor supervisor_;
  OutputCheck output_check_;
  Course course_;
  Course::Mark at_last_sample_{};  ///< that was accepted
  Oscillation oscillation_;
  AxisReport report_;
  double drive_ = 0.0;
  double tracking_since_s_ = 0.0;
  model::Interval reach_;  ///< allowed positions of a live setpoint
  double now_s_ = 0.0;     ///< reference time of the last step
  double waited_s_ = 0.0;  ///< until the last step
  AxisState state_ = AxisState::offline;
  bool stopping_ = false;
  bool memory_known_ = false;  ///< the model's memory agrees with the actuator's; false after a fault
};

}  // namespace hystcan::controller
