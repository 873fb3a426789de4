// The fault of an axis, and what follows from it:
//
//   none ─▶ safe                    the command is the safe one from the step of the fault on
//   none ─▶ ramping ─▶ safe         the drive ramps to the safe one first, where that is configured and the
//                                   cause leaves the drive in hand; ended at once by a later cause that does
//                                   not, and where bus or amplifier may not obey any more
//   safe ─▶ none                    by a clear; the ramp lasts until it has ended
#pragma once

#include <cstdint>

#include "controller/control/axis_config.h"
#include "controller/control/fault.h"

namespace hystcan::controller {

class Fall {
 public:
  enum class State : std::uint8_t { none, ramping, safe };

  /// The first fault is kept. `is_driven`: the axis was driven until now.
  void trip(const Fault& fault, bool is_driven, double ramp_per_s);
  /// Called once in each cycle of a faulted axis, with the drive that was commanded last.
  AxisCommand step(const AxisConfig& config, const AxisInput& input, OutputCheck& output_check,
                   double& drive);
  State state() const { return state_; }
  const Fault& fault() const { return fault_; }

 private:
  State state_ = State::none;
  Fault fault_;
  double ramp_per_s_ = 0.0;  ///< fault_ramp_per_s when the ramp began
};

}  // namespace hystcan::controller
