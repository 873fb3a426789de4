// The fault of an axis, and the reaction to it. The states are:
//
//   none ─▶ safe              from the step of the fault on, the command is the safe command
//   none ─▶ ramping ─▶ safe   the drive first ramps to its safe value, if the configuration requests this and
//                             the amplifier still follows commands after a fault with this cause. The ramp
//                             ends at once if a later cause excludes a ramp, or if the amplifier possibly
//                             does not receive or follow the commands
//   safe ─▶ none              the user clears the fault; this is refused during the ramp
#pragma once

#include <cstdint>

#include "controller/control/axis_config.h"
#include "controller/control/fault.h"

namespace hystcan::controller {

class Fall {
 public:
  enum class State : std::uint8_t { none, ramping, safe };

  /// Reacts to a fault. If the axis was driven and the cause allows a ramp, the drive ramps; otherwise the
  /// state is `safe` immediately. If the axis is faulted already, fault() still returns the first fault.
  /// `is_driven`: true if the axis was driven until now. `ramp_per_s`: slew of a ramp, 0 for no ramp.
  void trip(const Fault& fault, bool is_driven, double ramp_per_s);
  /// Called once in each cycle of a faulted axis. Returns the command. Replaces `drive`, the last commanded
  /// drive, by the new drive.
  AxisCommand step(const AxisConfig& config, const AxisInput& input, OutputCheck& output_check,
                   double& drive);
  State state() const { return state_; }
  const Fault& fault() const { return fault_; }

 private:
  State state_ = State::none;
  Fault fault_;
  double ramp_per_s_ = 0.0;  ///< slew of the ramp, drive units/s; fixed when the ramp starts
};

}  // namespace hystcan::controller
