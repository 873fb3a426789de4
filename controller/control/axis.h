// One axis: its supervisor, its gate, and the source of its drive (ClosedLoop in closed loop, Excitation in
// open loop). An axis is a pure step: it takes the time and the received data, and returns a command.
//
//   offline -> waiting -> initialising -> ready -> tracking      and from any state except offline to faulted
//
//   waiting       StartUp: the axis waits until both nodes are operational, the amplifier ready and at rest
//   initialising  StartUp: the drive ramps to the value at which tracking begins. In closed loop it ramps up
//                 to the upper threshold and down to the lower one: this wipes out the actuator's memory, so
//                 that the model's memory agrees with it. In open loop it ramps directly to the first drive
//                 of the excitation
//   ready         the axis holds that drive until the axes begin together, or joins the axes that track
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

/// A new configuration for a running axis; constructed outside the control thread.
struct AxisTuning {
  /// `new_reference`: true if the setpoint has changed; otherwise the present reference continues.
  AxisTuning(const AxisConfig& next, bool new_reference);
  AxisConfig config;
  std::optional<Trajectory> reference;
  std::optional<Learning> learning;
};

class Axis {
 public:
  /// Throws std::invalid_argument if the model is invalid, or if the excitation exceeds the gate's limits.
  explicit Axis(const AxisConfig& config);

  /// Starts the axis: it leaves the state offline, and tracks after the start-up. `clear_amplifier_fault`:
  /// tries once to clear a fault that is latched in the amplifier.
  void start(bool clear_amplifier_fault);
  /// Ramps to the safe drive, then switches the amplifier off and goes offline.
  void stop() { stopping_ = true; }
  /// Clears a fault and returns to offline; the next start tries once to clear the amplifier's fault.
  std::optional<Refusal> clear();
  void trip(Cause cause, double time_s);

  /// Live setpoint: moves smoothly to this position and stays there. Refused if the axis does not track a
  /// reference, if the position is outside position_min_um..position_max_um, or if the model cannot reach it.
  /// Does not allocate.
  std::optional<Refusal> go_to(double position_um);
  /// Ends a live setpoint: the axis follows the configured reference again.
  std::optional<Refusal> resume();

  /// Replaces the configuration, except for the model. `tuning` then contains the previous configuration.
  /// Called between two cycles.
  std::optional<Refusal> retune(AxisTuning& tuning);

  /// Returns the law whose memory is to be saved after a clean stop. Returns null if the memory of the
  /// actuator is unknown, or in open loop.
  const ControlLaw* law_to_save() const;
  /// Sets the saved memory of the actuator, which is ignored unless start-up is `restore`. Called before the
  /// first start.
  void restore(const model::HysteresisState& memory);
  /// Returns the closed loop; null in open loop.
  ClosedLoop* closed_loop() { return closed_loop_ ? &*closed_loop_ : nullptr; }
  const ClosedLoop* closed_loop() const { return closed_loop_ ? &*closed_loop_ : nullptr; }

  /// Returns the reference at `time_s`: the time since the controller's start, minus the delays of the
  /// references by late SYNCs (sync_clock.h). If the axis does not track a reference, returns the last
  /// measured position.
  double expected_um(double time_s) const;

  /// Returns the point of the reference at `time_s`: the time since the controller's start, minus the delays
  /// of the references by late SYNCs (sync_clock.h). Returns `nullopt` if the axis does not track a
  /// reference.
  std::optional<Trajectory::Point> reference_at(double time_s) const;

  /// Calls decide() and finish(). Called exactly once per cycle.
  AxisCommand step(const AxisInput& input);
  /// Evaluates the reference for the next decide() in advance, so that decide() takes less time.
  /// `reference_time_s`: value that AxisInput::reference_time_s() will return for this decide(). The call is
  /// optional.
  void prepare(double reference_time_s, double cycle_s);
  /// Decides the command of this cycle. finish() should be called after the command has been sent.
  AxisCommand decide(const AxisInput& input);
  /// Does the work of this cycle that is not needed for its command, so that the command can be sent earlier.
  void finish();

  AxisState state() const { return state_; }
  /// True if the axis expects a sample and sends a command in every cycle.
  bool is_in_use() const { return controller::is_in_use(state_) || fall_.state() == Fall::State::ramping; }
  const Fault& fault() const { return fall_.fault(); }
  const AxisReport& report() const { return report_; }
  const AxisConfig& config() const { return config_; }

 private:
  AxisCommand supervise(const AxisInput& input);
  AxisInput examine(const AxisInput& input);
  AxisCommand act(const AxisInput& input);
  AxisCommand start_up(const AxisInput& input);
  AxisCommand hold_ready(const AxisInput& input);
  AxisCommand track(const AxisInput& input);
  AxisCommand park(const AxisInput& input);
  ClosedLoop* loop_for_live_setpoints();

  AxisConfig config_;
  std::optional<ClosedLoop> closed_loop_;  ///< empty in open loop: excitation_ then decides the drive
  std::optional<Excitation> excitation_;
  StartUp start_up_;
  Fall fall_;
  Supervisor supervisor_;
  OutputCheck output_check_;
  Course course_;
  Course::Mark at_last_sample_{};  ///< positions of the model (Course) at the last accepted sample
  Oscillation oscillation_;
  AxisReport report_;
  double drive_ = 0.0;
  std::optional<double> uncommitted_drive_;  ///< drive that finish() must still pass to the closed loop
  double tracking_since_s_ = 0.0;
  model::Interval reach_;  ///< allowed positions of a live setpoint
  double now_s_ = 0.0;     ///< AxisInput::reference_time_s() of the last step
  double waited_s_ = 0.0;  ///< AxisInput::waited_s of the last step
  AxisState state_ = AxisState::offline;
  bool finished_ = true;  ///< finish() was called after the last decide()
  bool stopping_ = false;
  bool memory_known_ = false;  ///< the model's memory agrees with the actuator's; false after a fault
};

}  // namespace hystcan::controller
