// One axis: supervisor, loop and gate. Pure: told the time and what was heard, answers with a command.
//
//   offline -> waiting -> initialising -> ready -> tracking      and `faulted` from anywhere
//
//   waiting       until both nodes are operational and the amplifier reports itself ready, at rest
//   initialising  ramps to where tracking begins. Closed loop: up to the upper threshold and down to the
//                 lower one, so that what the actuator remembered is wiped out and the model's memory is
//                 true. Open loop: straight to the first drive of the excitation
//   ready         holds that drive until every axis is ready
//   tracking      the closed loop follows its reference, or the open loop its excitation
//   faulted       latched with cause and time; the command is the safe one from the same step on
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "controller/control/fault.h"
#include "controller/control/gate.h"
#include "controller/control/law.h"
#include "controller/control/loop.h"
#include "controller/control/supervisor.h"
#include "controller/reference/excitation.h"
#include "controller/reference/trajectory.h"

namespace hystcan::controller {

enum class AxisState : std::uint8_t { offline, waiting, initialising, ready, tracking, faulted };
inline constexpr std::size_t axis_state_count = static_cast<std::size_t>(AxisState::faulted) + 1;
std::string_view to_string(AxisState state);
/// Its nodes take part in every cycle: a sample is to come, and the command that answers it.
inline bool is_in_use(AxisState state) { return state > AxisState::waiting && state != AxisState::faulted; }

/// How an axis comes to know what its actuator remembers, before it tracks.
enum class StartUp : std::uint8_t {
  wipe,     ///< to both thresholds, which wipes all memory out
  assume,   ///< nothing since the lower threshold but the way to the drive that the amplifier reports
  restore,  ///< what was saved at the last clean stop (Axis::restore)
};
constexpr auto words(StartUp) { return std::to_array<std::string_view>({"wipe", "assume", "restore"}); }

/// Where another axis moves, this one's position changes too:  y = own + um_per_um * (position of `from`).
struct Coupling {
  std::string from;  ///< name of the other axis
  double um_per_um = 0.0;
  std::size_t index = 0;  ///< of that axis
};

struct AxisConfig {
  std::string name;
  ControlLaw::Config law;
  Gate::Config gate;
  Delays delays;
  std::vector<Segment> setpoint;
  bool repeat = false;
  ReferenceLimits reference_limits{};
  std::optional<InPosition::Config> in_position{};  ///< empty: not judged
  StartUp start_up = StartUp::wipe;
  double wipe_slew_per_s =
      100.0;  ///< drive units per second, towards the thresholds and, at the end, the safe drive
  double wipe_dwell_s = 0.1;          ///< rest at each threshold
  std::vector<Coupling> couplings{};  ///< fed forward; a row of the matrix
  Supervisor::Config supervision{};
  FollowingError::Config following_error{};
  std::optional<Excitation::Config> excitation{};  ///< open loop: in the place of law and setpoint
};

/// Everything about one cycle of one axis that is worth keeping.
struct AxisReport {
  AxisState state = AxisState::offline;
  Cause cause = Cause::none;
  double fault_time_s = 0.0;  ///< since the controller's start
  double reference_um = 0.0;  ///< NaN in open loop, demand_um too
  double position_um = 0.0;   ///< the last one measured
  double demand_um = 0.0;     ///< what the inverse was asked for
  double drive = 0.0;         ///< what left the gate
  std::uint8_t limits = limit::none;
  ModelCorrection correction;  ///< of the model, as learnt so far
  bool sample_missing = false;
  Trajectory::Point point;
  Arrival arrival = Arrival::not_judged;  ///< judged while tracking
};

/// What a running axis may be given in the place of its configuration; made off the control thread.
struct AxisTuning {
  /// `new_reference`: the setpoint has changed, else the reference goes on as it is.
  AxisTuning(const AxisConfig& next, bool new_reference);
  AxisConfig config;
  ClosedLoop::Config loop;
  std::optional<Trajectory> reference;
};

/// What became of a live setpoint.
enum class LiveSetpoint : std::uint8_t { taken, not_tracking, out_of_range };

class Axis {
 public:
  /// Throws std::invalid_argument where the model is not a valid one, or the excitation goes beyond the gate.
  explicit Axis(const AxisConfig& config);

  /// Towards tracking, from offline. `clear_amplifier_fault`: one that the amplifier has latched too.
  void start(bool clear_amplifier_fault);
  /// Ramps to the safe drive, then switches off: offline when done.
  void stop() { stopping_ = true; }
  /// A fault is forgotten, and the amplifier's will be with the next start: offline. False: nothing is
  /// faulted.
  bool clear();
  void trip(Cause cause, double time_s);

  /// Live: to this position, smoothly, and stay there. Refused where the axis does not track a reference, and
  /// outside position_min_um..position_max_um or what the model reaches at its thresholds. Allocates nothing.
  LiveSetpoint go_to(double position_um);
  /// Live: follow the configured reference again.
  LiveSetpoint resume();

  /// Between two cycles: everything but the model. `tuning` is left with what was in force. Why not, and
  /// nothing is changed; empty where it is done.
  std::string_view retune(AxisTuning& tuning);

  /// Memory and correction, to be saved after a clean stop. Null: the memory is not known, or there is none.
  const ControlLaw* law_to_save() const;
  /// Before the first start: what was saved. Where start-up is not `restore` the memory is left alone.
  void restore(const model::HysteresisState& memory, const ModelCorrection& correction);
  /// The correction learnt so far is forgotten.
  void revert_correction();

  /// How far ahead of a cycle its reference is looked up; 0 in open loop.
  double preview_s(double cycle_s);
  /// Where it is to be at that time, or, where it does not track a reference, where it was measured last.
  double expected_um(double time_s) const;

  /// Exactly once per cycle.
  AxisCommand step(const AxisInput& input);

  AxisState state() const { return state_; }
  const Fault& fault() const { return fault_; }
  const AxisReport& report() const { return report_; }
  const AxisConfig& config() const { return config_; }

 private:
  AxisCommand supervise(const AxisInput& input);
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
  void follow(double drive);

  AxisConfig config_;
  Loop loop_;
  std::vector<double> ramp_in_;  ///< drives to rest at while initialising, in this order
  Supervisor supervisor_;
  AxisState state_ = AxisState::offline;
  Fault fault_;
  AxisReport report_;
  bool stopping_ = false;
  bool clear_amplifier_fault_ = false;
  double drive_ = 0.0;
  std::size_t ramp_ = 0;  ///< while initialising: on the way to this one
  double dwelt_s_ = 0.0;
  double tracking_since_s_ = 0.0;
  model::Interval reach_;      ///< positions that a live setpoint may ask for
  bool memory_known_ = false;  ///< what the model remembers is what the actuator does; not after a fault
  double now_s_ = 0.0;         ///< of the last step
};

}  // namespace hystcan::controller
