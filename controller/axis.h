// One axis: supervisor, loop and gate. Pure: told the time and what was heard, answers with a command.
//
//   offline -> waiting -> initialising -> ready -> tracking      and `faulted` from anywhere
//
//   waiting       until both nodes are operational and the amplifier reports itself ready
//   initialising  ramps to where tracking begins. Closed loop: up to the upper threshold and down to the
//                 lower one, so that what the actuator remembered is wiped out and the model's memory is
//                 true. Open loop: straight to the first drive of the excitation
//   ready         holds that drive until every axis is ready
//   tracking      the closed loop follows its reference, or the open loop its excitation
//   faulted       latched with cause and time; the command is the safe one from the same step on
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "controller/excitation.h"
#include "controller/gate.h"
#include "controller/law.h"
#include "controller/loop.h"
#include "controller/setpoint.h"

namespace hystcan::controller {

enum class AxisState : std::uint8_t { offline, waiting, initialising, ready, tracking, faulted };
inline constexpr std::size_t axis_state_count = static_cast<std::size_t>(AxisState::faulted) + 1;
std::string_view to_string(AxisState state);

enum class Cause : std::uint8_t {
  none,
  interface_down,
  bus_off,
  cycle_overrun,
  sample_missing,
  sensor_status,
  position_implausible,
  sensor_silent,
  amplifier_silent,
  node_restarted,
  node_not_set_up,
  amplifier_fault,
  amplifier_not_enabled,
  following_error,
  command_not_sendable,
  another_controller,
};
inline constexpr std::size_t cause_count = static_cast<std::size_t>(Cause::another_controller) + 1;
std::string_view to_string(Cause cause);
/// What the engineer can do about it, in one sentence.
std::string_view remedy(Cause cause);

struct Fault {
  Cause cause = Cause::none;
  double time_s = 0.0;  ///< since the controller's start
};

/// Fills by one for every lost sample, leaks by a tenth for every good one: single losses are bridged, a run
/// trips.
class LeakyBucket {
 public:
  explicit LeakyBucket(unsigned capacity) : capacity_(10 * capacity) {}
  void lose() { level_ += 10; }
  void leak() { level_ -= level_ > 0 ? 1 : 0; }
  void empty() { level_ = 0; }
  bool overflows() const { return level_ > capacity_; }

 private:
  unsigned capacity_;
  unsigned level_ = 0;
};

struct AxisConfig {
  std::string name;
  ControlLaw::Config law;
  Gate::Config gate;
  Delays delays;
  std::vector<Segment> setpoint;
  bool repeat = false;
  double wipe_slew_per_s =
      100.0;  ///< drive units per second, towards the thresholds and, at the end, the safe drive
  double wipe_dwell_s = 0.1;     ///< rest at each threshold
  double position_min_um = 0.0;  ///< outside: implausible, a broken sensor or stage
  double position_max_um = 0.0;
  double following_error_um = 0.0;                 ///< trips where exceeded ...
  unsigned following_error_cycles = 1;             ///< ... for as many cycles in a row
  unsigned missing_samples = 3;                    ///< bridged in a row; one more trips
  std::optional<Excitation::Config> excitation{};  ///< open loop: in the place of law and setpoint
};

/// What is known of the axis's two nodes when a cycle is decided.
struct NodeHealth {
  bool interface_up = true;
  bool bus_on = true;         ///< not bus-off
  bool sensor_alive = false;  ///< heartbeat heard in time
  bool sensor_operational = false;
  bool amplifier_alive = false;
  bool amplifier_operational = false;
  bool restarted = false;          ///< a node booted up since the last cycle
  bool amplifier_ready = false;    ///< last status: ready or enabled
  bool amplifier_enabled = false;  ///< last status: enabled
  bool amplifier_fault = false;    ///< last status: fault
  double amplifier_output = 0.0;   ///< last status, drive units
};

struct AxisInput {
  double time_s = 0.0;                ///< of this cycle's SYNC, since the controller's start
  double dt_s = 0.0;                  ///< since the last cycle's SYNC
  double cycle_s = 0.0;               ///< the nominal period
  std::optional<double> position_um;  ///< empty: no sample came
  bool sensor_status_good = true;
  bool begin_tracking = false;  ///< every axis is ready
  NodeHealth health;
};

struct AxisCommand {
  double drive = 0.0;
  bool enable = false;
  bool clear_fault = false;
};

/// Everything about one cycle of one axis that is worth keeping.
struct AxisReport {
  AxisState state = AxisState::offline;
  Cause cause = Cause::none;
  double reference_um = 0.0;  ///< NaN in open loop, demand_um too
  double position_um = 0.0;   ///< the last one measured
  double demand_um = 0.0;     ///< what the inverse was asked for
  double drive = 0.0;         ///< what left the gate
  std::uint8_t limits = limit::none;
  bool sample_missing = false;
  bool in_position = false;
  Trajectory::Point point;
};

/// What became of a live setpoint.
enum class LiveSetpoint : std::uint8_t { taken, not_tracking, out_of_range };

class Axis {
 public:
  /// Throws std::invalid_argument where the model is not a valid one, or the excitation goes beyond the gate.
  explicit Axis(const AxisConfig& config);

  void start(bool clear_amplifier_fault);
  /// Ramps to the safe drive, then switches off: offline when done.
  void stop() { stopping_ = true; }
  void trip(Cause cause, double time_s);

  /// Live: to this position, smoothly, and stay there. Refused where the axis does not track a reference, and
  /// outside position_min_um..position_max_um or what the model reaches at its thresholds. Allocates nothing.
  LiveSetpoint go_to(double position_um);
  /// Live: follow the configured reference again.
  LiveSetpoint resume();
  /// Where go_to() has sent it. Empty: it follows the configured reference.
  std::optional<double> live_goal_um() const { return live_goal_um_; }

  /// Exactly once per cycle.
  AxisCommand step(const AxisInput& input);

  AxisState state() const { return state_; }
  const Fault& fault() const { return fault_; }
  const AxisReport& report() const { return report_; }
  const AxisConfig& config() const { return config_; }

 private:
  Cause find_cause(const AxisInput& input);
  AxisCommand decide(const AxisInput& input);
  AxisCommand wait(const AxisInput& input);
  AxisCommand initialise(const AxisInput& input);
  AxisCommand hold_ready(const AxisInput& input);
  AxisCommand track(const AxisInput& input);
  AxisCommand park(const AxisInput& input);
  AxisCommand safe() const;
  bool ramp_towards(double target, double dt_s);
  bool is_driving() const;
  bool takes_live_setpoints() const;

  AxisConfig config_;
  Loop loop_;
  std::vector<double> ramp_in_;  ///< drives to rest at while initialising, in this order
  LeakyBucket lost_samples_;
  AxisState state_ = AxisState::offline;
  Fault fault_;
  AxisReport report_;
  bool stopping_ = false;
  bool clear_amplifier_fault_ = false;
  double drive_ = 0.0;
  std::size_t ramp_ = 0;  ///< while initialising: on the way to this one
  double dwelt_s_ = 0.0;
  double enabled_for_s_ = 0.0;
  double tracking_since_s_ = 0.0;
  model::Interval reach_;  ///< positions that a live setpoint may ask for
  std::optional<double> live_goal_um_;
};

}  // namespace hystcan::controller
