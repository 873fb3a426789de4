#include "twin/plant.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "model/refusal.h"

namespace hystcan::twin {
namespace {

/// A reference that grows from period to period, as with a controller that learns, nests two turning points
/// in each; what no longer fits is merged, which would be a jump that no actuator makes.
constexpr std::size_t remembered_branches = 4096;

/// Neighbouring lengths lie far apart in a table of a power of two entries (Knuth's multiplicative hashing).
std::size_t slot_of(can::Duration length, std::size_t slots) {
  return static_cast<std::size_t>((static_cast<std::uint64_t>(length.count()) * 0x9E3779B97F4A7C15U) >> 32U) %
         slots;
}

}  // namespace

Plant::Step::Step(const Config& config, can::Duration step_length)
    : length(step_length),
      amplifier(config.amplifier, can::seconds(step_length)),
      mode(config.mode, can::seconds(step_length)) {}

Plant::Plant(const Config& config, can::Time start)
    : config_(config),
      undisturbed_mode_(config.mode),
      hysteresis_(config.hysteresis),
      memory_(hysteresis_.virgin(config.amplifier.safe_drive, remembered_branches)),
      rest_um_(memory_.output),
      substep_(config, config.substep),
      settled_{.time = start,
               .amplifier = {config.amplifier.safe_drive, config.amplifier.safe_drive},
               .hysteresis_um = rest_um_,
               .input_um = rest_um_,
               .mode = {rest_um_, 0.0}},
      present_(settled_),
      next_grid_(start + config.substep) {}

void Plant::advance_to(can::Time time) {
  if (time <= present_.time) return;
  while (next_grid_ <= time) {
    const double drive = settled_.amplifier.output;
    const bool whole = next_grid_ - settled_.time == config_.substep;
    move(settled_, step_of(next_grid_ - settled_.time), [this](double at) {
      hysteresis_.advance(memory_, at);
      return memory_.output;
    });
    if (whole && settled_.amplifier.output == drive && has_settled()) skip_rest(time);
    reach_grid();
  }
  present_ = settled_;
  if (time > settled_.time)
    move(present_, step_of(time - settled_.time),
         [this](double at) { return hysteresis_.forward(memory_, at).value; });
}

void Plant::set_target(double drive) {
  const double target = std::clamp(drive, config_.amplifier.drive_min, config_.amplifier.drive_max);
  if (target == present_.amplifier.target) return;
  split();
  settled_.amplifier.target = present_.amplifier.target = target;
}

void Plant::disturb(const Disturbance& disturbance) {
  if (!std::isfinite(disturbance.load_um))
    model::refuse("load_um = ", disturbance.load_um, ", expected a finite number");
  if (!std::isfinite(disturbance.gain))
    model::refuse("gain = ", disturbance.gain, ", expected a finite number");
  if (!std::isfinite(disturbance.resonance) || disturbance.resonance <= 0.0)
    model::refuse("resonance = ", disturbance.resonance, ", expected a positive number");
  split();
  disturbance_ = disturbance;
  config_.mode.natural_frequency_Hz = undisturbed_mode_.natural_frequency_Hz * disturbance.resonance;
  substep_ = Step(config_, config_.substep);
  parts_.fill(std::nullopt);
  settled_.input_um = present_.input_um = input_um(settled_);
}

/// From the present one to the end of `step`; `hysteresis` gives x_h at a drive.
template <class Hysteresis>
void Plant::move(Motion& motion, const Step& step, Hysteresis hysteresis) {
  motion.time += step.length;
  motion.amplifier = step.amplifier(motion.amplifier);
  motion.hysteresis_um = hysteresis(motion.amplifier.output + noise_);
  const double before = motion.input_um;
  motion.input_um = input_um(motion);
  motion.mode = step.mode(motion.mode, before, motion.input_um);
}

const Plant::Step& Plant::step_of(can::Duration length) {
  if (length == config_.substep) return substep_;
  std::optional<Step>& part = parts_[slot_of(length, parts_.size())];
  if (!part || part->length != length) part.emplace(config_, length);
  return *part;
}

/// The motion goes on from the time looked at, in two parts of a sub-step.
void Plant::split() {
  if (present_.time == settled_.time) return;
  hysteresis_.advance(memory_, drive());
  settled_ = present_;
}

/// The sub-step that begins here: its noise moves the drive at once.
void Plant::reach_grid() {
  next_grid_ = settled_.time + config_.substep;
  if (drive_noise_) {
    noise_ = drive_noise_(settled_.time);
    hysteresis_.advance(memory_, settled_.amplifier.output + noise_);
    settled_.hysteresis_um = memory_.output;
    settled_.input_um = input_um(settled_);
  }
  if (on_grid_) on_grid_(settled_.time, settled_.mode.position);
}

void Plant::skip_rest(can::Time time) {
  settled_.time += (time - settled_.time) / config_.substep * config_.substep;
}

// From here on only rounding would move it: it is put at rest.
bool Plant::has_settled() {
  constexpr double nothing_um = 1e-12;
  if (drive_noise_) return false;
  const double speed_um = settled_.mode.velocity / config_.mode.natural_frequency_Hz;
  if (std::abs(settled_.mode.position - settled_.input_um) > nothing_um || std::abs(speed_um) > nothing_um)
    return false;
  settled_.mode = {settled_.input_um, 0.0};
  return true;
}

double Plant::input_um(const Motion& motion) const {
  return motion.hysteresis_um + (disturbance_.gain - 1.0) * (motion.hysteresis_um - rest_um_) +
         disturbance_.load_um;
}

}  // namespace hystcan::twin
