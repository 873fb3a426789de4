// The start-up of an axis, until its drive is where tracking begins:
//
//   arming ─▶ following ─▶ ramping ─▶ ended
//     ▲           └─▶ approaching ─▶ withholding ─┐
//     └───────────────────────────────────────────┘        where the watchdog is to be tried, once
//
//   arming       both nodes must be operational, the amplifier ready and at rest; nothing is driven
//   following    the drive is held where the amplifier's output is until the amplifier is enabled
//   approaching  the drive ramps to the safe one
//   withholding  nothing is commanded: the amplifier must trip, and is then armed again
//   ramping      the drive visits the targets, as far as the output follows it, and rests at each
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "controller/control/arming.h"
#include "controller/control/axis_config.h"
#include "controller/control/axis_report.h"

namespace hystcan::controller {

class StartUp {
 public:
  enum class State : std::uint8_t { arming, following, approaching, withholding, ramping, ended };
  struct Step {
    AxisCommand command;
    Cause cause = Cause::none;
    bool moves = false;  ///< the drive was set: the model's memory is to follow it
  };
  /// What the axis knows besides the input.
  struct Known {
    bool enabled = false;  ///< the amplifier's output follows the drive
    bool output_differs = false;
    bool memory = false;  ///< of the actuator: no target is visited
  };

  explicit StartUp(const AxisConfig& config) : ramp_check_(ramp_check_of(config)) {}

  /// The drives to visit and to rest at, in order.
  void visit(std::vector<double> targets) { targets_ = std::move(targets); }

  /// `clear_fault`: with one attempt to clear a fault that is latched in the amplifier.
  void begin(bool clear_fault);
  /// The next arming makes that attempt, or no longer.
  void attempt_clear(bool attempt);
  void retune(const AxisConfig& config) { ramp_check_ = RampCheck(ramp_check_of(config)); }
  /// Called once in each cycle. Fills in what the axis waits for.
  Step step(const AxisConfig& config, const AxisInput& input, const Known& known, double& drive,
            AxisReport& report);
  /// Called once in each cycle. False: the position contradicts the ramp.
  bool agrees(const Course& course, double drive, const AxisInput& input);
  State state() const { return state_; }

 private:
  bool is_ramping() const { return state_ == State::approaching || state_ == State::ramping; }
  Step wait(const AxisConfig& config, const AxisInput& input, AxisReport& report);
  void begin_with(std::size_t target) {
    next_ = target;
    dwelt_s_ = 0.0;
  }

  State state_ = State::arming;
  std::vector<double> targets_;
  RampCheck ramp_check_;
  ClearAttempt clear_attempt_;
  double withheld_for_s_ = 0.0;
  bool watchdog_verified_ = false;
  std::size_t next_ = 0;  ///< target
  double dwelt_s_ = 0.0;  ///< there
};

}  // namespace hystcan::controller
