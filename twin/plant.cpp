#include "twin/plant.h"

#include <algorithm>
#include <cmath>

namespace hystcan::twin {
namespace {

/// A reference that grows from period to period, as with a controller that learns, nests two turning points
/// in each; what no longer fits is merged, which would be a jump that no actuator makes.
constexpr std::size_t remembered_branches = 4096;

}  // namespace

Plant::Step::Step(const Config& config, can::Duration length)
    : amplifier(config.amplifier, can::seconds(length)), mode(config.mode, can::seconds(length)) {}

Plant::Plant(const Config& config, can::Time start)
    : config_(config),
      hysteresis_(config.hysteresis),
      substep_(config, config.substep),
      now_(start),
      amplifier_{config.amplifier.safe_drive, config.amplifier.safe_drive},
      memory_(hysteresis_.virgin(config.amplifier.safe_drive, remembered_branches)),
      mode_{memory_.output, 0.0} {}

void Plant::advance_to(can::Time time) {
  for (; time - now_ >= config_.substep; now_ += config_.substep) {
    const double drive = amplifier_.output;
    take(substep_);
    if (amplifier_.output == drive && has_settled())
      now_ += (time - now_) / config_.substep * config_.substep - config_.substep;
  }
  if (time <= now_) return;
  take(Step(config_, time - now_));
  now_ = time;
}

void Plant::set_target(double drive, Amplifier::Course course) {
  amplifier_.target = Amplifier::target_of(config_.amplifier, drive);
  amplifier_.course = course;
}

// From here on only rounding would move it: it is put at rest.
bool Plant::has_settled() {
  constexpr double nothing_um = 1e-12;
  const double speed_um = mode_.velocity / config_.mode.natural_frequency_Hz;
  if (std::abs(mode_.position - memory_.output) > nothing_um || std::abs(speed_um) > nothing_um) return false;
  mode_ = {memory_.output, 0.0};
  return true;
}

void Plant::take(const Step& step) {
  const double before = memory_.output;
  amplifier_ = step.amplifier(amplifier_);
  hysteresis_.advance(memory_, amplifier_.output);
  mode_ = step.mode(mode_, before, memory_.output);
}

}  // namespace hystcan::twin
