// The closed loop decides the drive of an axis while the axis tracks a reference. It contains Trajectory,
// ControlLaw, FollowingError and Learning. In open loop an Excitation decides the drive instead (axis.h).
//
// Calls, in this order:
//
//   ramp_in(gate)                     returns the drives to visit before tracking
//   follow()                          takes each drive that is applied before tracking
//   settle()                          called when the amplifier is armed: the actuator has rested until then
//   elapse()                          time passes: in every cycle, before its drive is decided
//   begin()                           tracking begins, together with the other axes or after them
//   prepare()                         optional, when the time of the next propose() is known
//   propose() -> gate -> commit()     in every cycle
#pragma once

#include <optional>
#include <vector>

#include "controller/control/axis_config.h"
#include "controller/control/axis_report.h"
#include "controller/control/supervisor.h"

namespace hystcan::controller {

class ClosedLoop {
 public:
  /// Throws std::invalid_argument if the model is invalid.
  explicit ClosedLoop(const AxisConfig& config);

  /// Returns the drives that wipe out the actuator's memory: the upper threshold, and then the lower
  /// threshold. If the drive reaches the upper threshold, the lower threshold is omitted in two cases: the
  /// drive cannot reach it, or the actuator is a butterfly actuator, which works only on the side of its
  /// valley where the upper threshold is.
  std::vector<double> ramp_in(const Gate::Config& gate) const;
  void follow(double applied_drive) { law_.follow(applied_drive); }
  void settle() { law_.settle(); }
  void elapse(double dt_s) { law_.elapse(dt_s); }
  /// Begins to track. `coupled_um`: present displacement by the other axes. `goes_on`: this axis has tracked
  /// before and was stopped, while t_s continued from the same origin (see Trajectory::join).
  void begin(double t_s, double position_um, double coupled_um, bool goes_on = false);
  /// Evaluates the reference for propose() at the time `t_s` in advance, so that propose() takes less time.
  void prepare(double t_s, double cycle_s);
  /// Returns the requested drive, before the gate, and fills the values of the loop into `report`. Returns
  /// `nullopt` if the stage does not follow its reference any more (FollowingError). `t_s`: time since the
  /// axes began to track. `waited`: the drive was held for longer than dt_s, because SYNCs were omitted.
  std::optional<double> propose(const AxisInput& input, double t_s, bool waited, AxisReport& report);
  /// Takes the drive that was applied. `limits`: all limits that were active for this drive.
  void commit(double applied_drive, std::uint8_t limits);

  void go_to(double t_s, double goal_um);
  void resume(double t_s);
  /// Applies everything of `config` except the model and the setpoint. The drive does not jump. If
  /// `reference` has a value, it continues the present motion; afterwards `reference` contains the previous
  /// reference. If `learning` has a value, the present learning is exchanged for it; otherwise the present
  /// learning ends. Called between two cycles; does not allocate.
  void retune(const AxisConfig& config, std::optional<Trajectory>& reference,
              std::optional<Learning>& learning, double t_s);

  /// Returns the time by which the feed-forward evaluates the reference ahead: the mean delay from demand to
  /// position.
  double preview_s(double cycle_s);
  double reference_um(double t_s) const { return trajectory_.value_um(t_s); }
  Trajectory::Point reference_at(double t_s) const { return trajectory_.at(t_s); }

  Learning* learning() { return learning_ ? &*learning_ : nullptr; }
  const Learning* learning() const { return learning_ ? &*learning_ : nullptr; }
  const ControlLaw& law() const { return law_; }
  ControlLaw& law() { return law_; }

 private:
  void apply(const AxisConfig& config);
  /// The part of the reference that must not change, because the last cycle or prepare() has already used it.
  /// It begins at since_s and lasts for_s.
  struct Used {
    double since_s = 0.0, for_s = 0.0;
  };
  Used used(double t_s) const;
  Learning::Correction learn(const AxisInput& input, double t_s, double expected_um, bool waited,
                             const Trajectory::Point& point);
  double expected_um(double t_s, double cycle_s, const Trajectory::Point& point);
  double previewed_um(double t_s, double cycle_s);

  Delays delays_;
  std::optional<PlantInverse> plant_inverse_;
  std::optional<Notch::Config> notch_;
  std::optional<InPosition::Config> judged_by_;
  ControlLaw law_;
  Trajectory trajectory_;
  /// The values of the reference for one propose().
  struct Prepared {
    double t_s = 0.0;
    Trajectory::Point point;
    double expected_um = 0.0;  ///< the value with which PI compares the sample
    double previewed_um = 0.0;
  };
  std::optional<Prepared> prepared_;
  InPosition::State in_position_;
  FollowingError following_error_;
  std::optional<Learning> learning_;
  bool is_limited_ = false;     ///< a limit was active for the last drive
  Moments moments_;             ///< mean delay and variance from demand to position
  double moments_for_s_ = 0.0;  ///< the cycle time for which moments_ was computed; 0: not computed yet
  double coupled_at_first_um_ = 0.0;
};

}  // namespace hystcan::controller
