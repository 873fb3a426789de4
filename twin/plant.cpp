#include "twin/plant.h"

#include <algorithm>

namespace hystcan::twin {
Plant::Step::Step(const Config& config, can::Duration length)
    : amplifier(config.amplifier, can::seconds(length)), mode(config.mode, can::seconds(length)) {}

Plant::Plant(const Config& config, can::Time start)
    : config_(config),
      hysteresis_(config.hysteresis),
      substep_(config, config.substep),
      now_(start),
      amplifier_{config.amplifier.safe_drive, config.amplifier.safe_drive},
      memory_(hysteresis_.virgin(config.amplifier.safe_drive)),
      mode_{memory_.output, 0.0} {}

void Plant::advance_to(can::Time time) {
  for (; time - now_ >= config_.substep; now_ += config_.substep) take(substep_);
  if (time <= now_) return;
  take(Step(config_, time - now_));
  now_ = time;
}

void Plant::set_target(double drive) {
  amplifier_.target = std::clamp(drive, config_.amplifier.drive_min, config_.amplifier.drive_max);
}

void Plant::take(const Step& step) {
  const double before = memory_.output;
  amplifier_ = step.amplifier(amplifier_);
  hysteresis_.advance(memory_, amplifier_.output);
  mode_ = step.mode(mode_, before, memory_.output);
}

}  // namespace hystcan::twin
