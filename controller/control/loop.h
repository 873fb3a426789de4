// The two loops that decide the drive of an axis while it tracks. Both have the same supervision and gate.
//
//   ClosedLoop   follows a reference: Trajectory, ControlLaw, following error
//   OpenLoop     follows an Excitation (a drive); has no model and no reference
//
// Calls, in this order:
//
//   ramp_in(gate)                     returns the drives to visit before tracking
//   settle()                          the actuator has stood at the drive that was followed last
//   follow()                          takes each drive applied on the way there
//   elapse()                          time passes: in every cycle, before its drive is decided
//   begin()                           tracking begins, with the other axes or after them
//   propose() -> gate -> commit()     in every cycle
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "controller/control/delays.h"
#include "controller/control/following_error.h"
#include "controller/control/gate.h"
#include "controller/control/in_position.h"
#include "controller/control/law.h"
#include "controller/control/learning.h"
#include "controller/control/plant_inverse.h"
#include "controller/reference/excitation.h"
#include "controller/reference/trajectory.h"

namespace hystcan::controller {

struct LoopInput {
  double t_s = 0.0;  ///< since the axes began to track
  double dt_s = 0.0;
  double cycle_s = 0.0;
  std::optional<double> position_um;
  double coupled_um = 0.0;  ///< what the other axes will add to this one's position (model::Coupling)
  bool waited = false;      ///< the drive was held for longer than dt_s: SYNCs were left out
};

struct Proposal {
  bool follows = true;        ///< false: the stage has lost its reference; the other members mean nothing
  double drive = 0.0;         ///< requested, before the gate
  double reference_um = 0.0;  ///< that the sample is compared with: of the time that it shows
  double previewed_um = 0.0;  ///< input of the feed-forward
  double integral_um = 0.0;
  double demand_um = 0.0;
  std::uint8_t limits = limit::none;
  std::uint32_t memory_depth = 0;
  Learning::Report learning{};
  Trajectory::Point point;
  Arrival arrival = Arrival::not_judged;
};

class ClosedLoop {
 public:
  struct Config {
    ControlLaw::Config law;
    Delays delays;
    std::optional<PlantInverse::Config> plant_inverse{};  ///< instead of the preview by moments
    std::vector<Segment> setpoint;
    std::optional<Learning::Config> learning{};  ///< empty: it learns nothing
    bool repeat = false;
    ReferenceLimits reference_limits{};
    TransitionLimits transition_limits{};
    std::optional<InPosition::Config> in_position{};  ///< empty: not judged
    FollowingError::Config following_error;
  };

  /// Throws std::invalid_argument where the model is invalid.
  explicit ClosedLoop(const Config& config);

  /// Up to the upper threshold and down to the lower one: this wipes the actuator's memory out.
  std::vector<double> ramp_in(const Gate::Config& gate) const;
  void follow(double applied_drive) { law_.follow(applied_drive); }
  void settle() { law_.settle(); }
  void elapse(double dt_s) { law_.elapse(dt_s); }
  /// `goes_on`: the loop has tracked before, on the same time.
  void begin(double t_s, double position_um, double coupled_um, bool goes_on = false);
  Proposal propose(const LoopInput& input);
  /// `limits`: all that were active for this drive.
  void commit(double applied_drive, std::uint8_t limits);

  void go_to(double t_s, double goal_um);
  void resume(double t_s);
  /// Called between two cycles; has no bump and does not allocate. Applies everything of `config` but the
  /// model and the setpoint. A given `reference` starts from the present motion; it is exchanged for the
  /// former one.
  /// So is a given `learning`; without one the present one ends.
  void retune(const Config& config, std::optional<Trajectory>& reference, std::optional<Learning>& learning,
              double t_s);

  /// How far ahead the reference is looked up.
  double preview_s(double cycle_s);
  double reference_um(double t_s) const { return trajectory_.value_um(t_s); }
  Trajectory::Point reference_at(double t_s) const { return trajectory_.at(t_s); }

  Learning* learning() { return learning_ ? &*learning_ : nullptr; }
  const Learning* learning() const { return learning_ ? &*learning_ : nullptr; }
  const ControlLaw& law() const { return law_; }
  ControlLaw& law() { return law_; }

 private:
  void apply(const Config& config);
  double previewed_s() const;
  Learning::Correction learn(const Trajectory::Point& point, double expected_um, const LoopInput& input);
  Arrival judge(const Trajectory::Point& point, const LoopInput& input);
  double previewed_um(const LoopInput& input);
  double expected_um(const Trajectory::Point& point, const LoopInput& input);

  Delays delays_;
  std::optional<PlantInverse> plant_inverse_;
  std::optional<Notch::Config> notch_;
  std::optional<InPosition::Config> judged_by_;
  ControlLaw law_;
  Trajectory trajectory_;
  InPosition::State in_position_;
  FollowingError following_error_;
  std::optional<Learning> learning_;
  bool is_limited_ = false;     ///< the last drive was
  Moments moments_;             ///< from demand to position
  double moments_for_s_ = 0.0;  ///< the cycle time for which moments_ was computed; 0: none yet
  double coupled_at_first_um_ = 0.0;
};

class OpenLoop {
 public:
  /// Throws std::invalid_argument where `gate` would limit the excitation.
  OpenLoop(const Excitation::Config& config, const Gate::Config& gate);

  /// Straight to the first drive of the excitation.
  std::vector<double> ramp_in(const Gate::Config&) const { return {excitation_.at(0.0)}; }
  void follow(double /*applied_drive*/) {}
  void settle() {}
  void elapse(double /*dt_s*/) {}
  void begin(double /*t_s*/, double /*position_um*/, double /*coupled_um*/, bool /*goes_on*/) {}
  Proposal propose(const LoopInput& input) const;
  void commit(double /*applied_drive*/, std::uint8_t /*limits*/) {}

 private:
  Excitation excitation_;
};

using Loop = std::variant<ClosedLoop, OpenLoop>;

}  // namespace hystcan::controller
