#include "controller/control/start_up.h"

#include <algorithm>
#include <cmath>

namespace hystcan::controller {
namespace {

/// Share of the drive's range. If the amplifier's output differs from the drive by more than this, the output
/// has moved.
constexpr double output_moved = 0.01;

/// Lets the drive follow the amplifier's output before the amplifier's relay closes. If the output fell while
/// the relay is open, and the drive did not follow, the stage would jump when the relay closes.
void follow_output(const Gate::Config& gate, const AxisInput& input, double& drive) {
  double output = input.health.amplifier_output;
  if (!(std::abs(output - drive) > output_moved * (gate.drive_max - gate.drive_min))) output = drive;
  drive = Gate::step(gate, drive, output, input.dt_s).drive;
}

bool ramps_to(double target, const AxisConfig& config, const AxisInput& input, double& drive) {
  return Gate::approach(config.gate, drive, target, config.wipe_slew_per_s * input.dt_s, input.dt_s);
}

}  // namespace

void StartUp::begin(bool clear_fault) {
  state_ = State::arming;
  ramp_check_.restart();
  if (clear_fault) clear_attempt_.begin();
}

void StartUp::attempt_clear(bool attempt) {
  clear_attempt_ = {};
  if (attempt) clear_attempt_.begin();
}

// After Enable, a relay or a soft start needs up to half a second until the amplifier is enabled. Until then
// the amplifier's output does not follow the commands: a ramp of the commands would become a jump of the
// stage.
StartUp::Step StartUp::step(const AxisConfig& config, const AxisInput& input, const Known& known,
                            double& drive, AxisReport& report) {
  if (is_ramping() || (state_ == State::following && known.enabled))
    state_ = config.verify_watchdog && !watchdog_verified_ ? State::approaching : State::ramping;
  if (is_ramping() && known.output_differs) {
    report.arming_blocks = ArmingBlock::output;
    return {.command = {.drive = drive, .enable = true}};
  }
  Step taken{.command = {.enable = true}, .moves = true};
  switch (state_) {
    case State::arming:
      taken = wait(config, input, report);
      if (!report.arming_blocks.empty()) return taken;
      drive = std::clamp(input.health.amplifier_output, config.gate.drive_min, config.gate.drive_max);
      clear_attempt_ = {};  // ends the attempt to clear the amplifier's fault
      begin_with(config.start_up != MemorySource::wipe && known.memory ? targets_.size() : 0);
      state_ = State::following;
      return {.command = taken.command, .moves = true};
    case State::following:
      report.arming_blocks = ArmingBlock::enabled;
      follow_output(config.gate, input, drive);
      break;
    case State::approaching:
      report.arming_blocks = ArmingBlock::watchdog;
      withheld_for_s_ = 0.0;
      if (ramps_to(config.gate.safe_drive, config, input, drive)) state_ = State::withholding;
      break;
    case State::withholding:
      report.arming_blocks = ArmingBlock::watchdog;
      if (input.health.amplifier_fault) {
        watchdog_verified_ = true;
        report.watchdog_tripped_after_s = withheld_for_s_;
        begin(true);
        return {.command = config.safe_command()};
      }
      withheld_for_s_ += input.dt_s;
      if (withheld_for_s_ > watchdog_timeout_s) taken.cause = Cause::watchdog_failed;
      taken.command.withheld = true;
      taken.moves = false;
      break;
    case State::ramping:
      taken.moves = next_ < targets_.size();
      if (taken.moves && ramps_to(targets_[next_], config, input, drive)) {
        dwelt_s_ += input.dt_s;
        if (dwelt_s_ >= config.wipe_dwell_s) begin_with(next_ + 1);
      }
      if (next_ == targets_.size()) state_ = State::ended;
      break;
    case State::ended:
      taken.moves = false;
      break;
  }
  taken.command.drive = drive;
  return taken;
}

StartUp::Step StartUp::wait(const AxisConfig& config, const AxisInput& input, AxisReport& report) {
  Step taken{.command = config.safe_command()};
  taken.command.clear_fault = clear_attempt_.step(input.health, input.dt_s);
  report.arming_blocks = arming_blocks_of(input, config.gate);
  if (report.arming_blocks.first() == ArmingBlock::clear && !taken.command.clear_fault)
    taken.cause = Cause::amplifier_fault;
  return taken;
}

bool StartUp::agrees(const Course& course, double drive, const AxisInput& input) {
  if (state_ != State::arming && state_ != State::following) return ramp_check_.step(course, drive, input);
  ramp_check_.rest(course, drive, input);
  return true;
}

}  // namespace hystcan::controller
