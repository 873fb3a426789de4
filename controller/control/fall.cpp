#include "controller/control/fall.h"

namespace hystcan::controller {

void Fall::trip(const Fault& fault, bool is_driven, double ramp_per_s) {
  const bool may_ramp = state_ == State::none ? is_driven : state_ == State::ramping;
  if (state_ == State::none) fault_ = fault;
  if (state_ != State::ramping) ramp_per_s_ = ramp_per_s;
  const bool ramps = may_ramp && ramp_per_s_ > 0.0 && leaves_the_drive_in_hand(fault.cause);
  state_ = ramps ? State::ramping : State::safe;
}

AxisCommand Fall::step(const AxisConfig& config, const AxisInput& input, OutputCheck& output_check,
                       double& drive) {
  const double safe_drive = config.gate.safe_drive;
  output_check.step(drive, ramp_per_s_, input);
  if (drive == safe_drive || !obeys_commands(input.health) ||
      is_status_too_old(input.health, config.supervision.status_timeout) ||
      output_check.differs_too_long(false))
    state_ = State::safe;
  if (state_ == State::safe) return config.safe_command();
  Gate::approach(config.gate, drive, safe_drive, ramp_per_s_ * input.cycle_s, input.dt_s);
  return {.drive = drive, .enable = true};
}

}  // namespace hystcan::controller
