// The start-up of an axis, until its drive is at the value where tracking begins:
//
//   arming ─▶ following ─▶ ramping ─▶ ended
//     ▲           └─▶ approaching ─▶ withholding ─┐
//     └───────────────────────────────────────────┘        once, if the watchdog is to be tried
//
//   arming       the axis waits: both nodes must be operational, the amplifier ready and at rest
//   following    the drive follows the amplifier's output until the amplifier is enabled
//   approaching  the drive ramps to its safe value, before the trial of the amplifier's watchdog
//   withholding  no command is sent: the amplifier must trip, and is then armed again
//   ramping      the drive visits its targets, as fast as the amplifier's output follows, and rests at each
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "controller/control/arming.h"
#include "controller/control/axis_config.h"
#include "controller/control/axis_report.h"

namespace hystcan::controller {

/// Time in s without commands in which the amplifier must trip. If it does not, it has no watchdog that would
/// protect the stage.
inline constexpr double watchdog_timeout_s = 1.0;

class StartUp {
 public:
  enum class State : std::uint8_t { arming, following, approaching, withholding, ramping, ended };
  struct Step {
    AxisCommand command;
    Cause cause = Cause::none;
    bool moves = false;  ///< `drive` was set: the model's memory must follow it
  };
  /// Facts about the axis that are not part of AxisInput.
  struct Known {
    bool enabled = false;  ///< the amplifier's output follows the drive
    bool output_differs = false;
    bool memory = false;  ///< the actuator's memory is known: the ramp may be omitted
  };

  explicit StartUp(const AxisConfig& config) : ramp_check_(ramp_check_of(config)) {}

  /// Sets the values of the drive to which the ramp of the start-up moves, in this order. At each value, the
  /// drive stays constant for wipe_dwell_s.
  void visit(std::vector<double> targets) { targets_ = std::move(targets); }

  /// Begins the start-up in the state arming. `clear_fault`: tries once to clear a latched fault of the
  /// amplifier.
  void begin(bool clear_fault);
  /// Selects whether the next arming tries once to clear the amplifier's fault.
  void attempt_clear(bool attempt);
  void retune(const AxisConfig& config) { ramp_check_ = RampCheck(ramp_check_of(config)); }
  /// Called once in each cycle of the start-up. Returns the command, and stores in `report` the conditions
  /// for which the axis waits.
  Step step(const AxisConfig& config, const AxisInput& input, const Known& known, double& drive,
            AxisReport& report);
  /// Called once in each cycle of the start-up. Returns false if the position does not move as the model
  /// predicts for the ramp.
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
  std::size_t next_ = 0;  ///< index of the next target
  double dwelt_s_ = 0.0;  ///< time for which the drive has rested at the present target
};

}  // namespace hystcan::controller
