// The fault of an axis, and the reaction to it:
//
//   none ─▶ safe                    the command is the safe one from the step of the fault on
//   none ─▶ ramping ─▶ safe         the drive first ramps to the safe one, if this is configured and the
//                                   cause leaves the drive controllable. The ramp ends immediately if a later
//                                   cause does not, or if bus or amplifier may no longer obey
//   safe ─▶ none                    by a clear, which is refused during the ramp
#pragma once

#include <cstdint>

#include "controller/control/axis_config.h"
#include "controller/control/fault.h"

namespace hystcan::controller {

class Fall {
 public:
  enum class State : std::uint8_t { none, ramping, safe };

  /// Keeps the first fault. `is_driven`: true if the axis was driven until now.
  void trip(const Fault& fault, bool is_driven, double ramp_per_s);
  /// Called once in each cycle of a faulted axis. `drive`: the last commanded drive, replaced by the new one.
  AxisCommand step(const AxisConfig& config, const AxisInput& input, OutputCheck& output_check,
                   double& drive);
  State state() const { return state_; }
  const Fault& fault() const { return fault_; }

 private:
  State state_ = State::none;
  Fault fault_;
  double ramp_per_s_ = 0.0;  ///< fault_ramp_per_s at the start of the ramp
};

}  // namespace hystcan::controller
