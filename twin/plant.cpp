#include "twin/plant.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "base/text.h"
#include "model/hysteresis_operator.h"

namespace hystcan::twin {
namespace {

/// Capacity of the hysteresis memory. If the amplitude of the drive decreases with every period, as it can
/// under a learning controller, each period adds two nested turning points. A full memory would merge
/// branches, and the position would jump as no real actuator does.
constexpr std::size_t remembered_branches = 4096;

/// Number of sub-steps that are combined into one while only creep or temperature moves the stage. This makes
/// the simulation fast: three simulated days take one second.
constexpr int even_substeps = 1000;

/// Returns the place of a step of this length in a hash table (Knuth's multiplicative hashing).
std::size_t slot_of(can::Duration length, std::size_t slots) {
  return static_cast<std::size_t>((static_cast<std::uint64_t>(length.count()) * 0x9E3779B97F4A7C15U) >> 32U) %
         slots;
}

void check(const Plant::Config& config) {
  if (config.substep <= can::Duration::zero())
    refuse("substep = ", config.substep.count(), " ns, expected a positive time");
  if (config.second_mode && !(config.second_mode->share >= 0.0 && config.second_mode->share <= 1.0))
    refuse("second_mode share = ", config.second_mode->share, ", expected 0 to 1");
  if (!config.temperature) return;
  const Temperature& t = *config.temperature;
  if (!std::isfinite(t.period_s) || t.period_s <= 0.0)
    refuse("temperature period_s = ", t.period_s, ", expected a positive number");
  for (const double number : {t.swing_K, t.expansion_um_per_K, t.gain_per_K})
    if (!std::isfinite(number))
      refuse("temperature: swing_K, expansion_um_per_K or gain_per_K is ", number,
             ", expected a finite number");
}

Plant::Config checked(const Plant::Config& config) {
  check(config);
  return config;
}

model::Creep::Operators operators_of(const Plant::Config& config, const model::OutputCreep& of_model) {
  model::Creep::Operators all;
  if (const auto& creep = config.creep; creep && creep->per_decade != 0.0)
    all = model::logarithmic_creep(creep->per_decade, creep->from_s, creep->to_s);
  for (const double rate_per_s : of_model.rates_per_s())
    all.push_back({.weight = of_model.weight(), .rate_per_s = rate_per_s});
  return all;
}

model::SecondOrder::Config faster(model::SecondOrder::Config mode, double factor) {
  mode.natural_frequency_Hz *= factor;
  return mode;
}

// If the distance of the mode from rest is negligible, sets the mode to rest and returns true. Otherwise
// returns false.
bool settle(model::SecondOrder::State& state, const model::SecondOrder::Config& mode, double input_um) {
  constexpr double negligible_um = 1e-12;
  const double swing_um = state.velocity / mode.natural_frequency_Hz;
  if (std::abs(state.position - input_um) > negligible_um || std::abs(swing_um) > negligible_um) return false;
  state = {input_um, 0.0};
  return true;
}

}  // namespace

template <class Model>
Material::Kind<Model> Material::virgin(Model model, double drive, std::size_t branches) {
  if constexpr (requires { model.virgin(drive, branches); }) {
    auto state = model.virgin(drive, branches);
    return {std::move(model), std::move(state)};
  } else {
    auto state = model.virgin(drive);
    return {std::move(model), std::move(state)};
  }
}

Material::Material(const model::AnyParameters& parameters, double drive, std::size_t branches)
    : kind_(std::visit([&](const auto& model) { return decltype(kind_)(virgin(model, drive, branches)); },
                       model::model_of(parameters))),
      even_(std::visit([](const auto& kind) { return model::is_even(kind.model); }, kind_)),
      drive_(drive) {}

double Material::go_to(double drive) {
  if (even_) pass_zero(drive);
  drive_ = drive;
  return std::visit([drive](auto& kind) { return kind.model.advance(kind.state, drive).value; }, kind_);
}

double Material::look_at(double drive) {
  if (even_) pass_zero(drive);
  return std::visit([drive](auto& kind) { return kind.model.forward(kind.state, drive).value; }, kind_);
}

void Material::pass_zero(double drive) {
  if (drive * drive_ < 0.0) go_to(0.0);
}

Plant::Step::Step(const Config& config, const model::Creep::Operators& creep_operators,
                  can::Duration step_length)
    : length(step_length),
      amplifier(config.amplifier, can::seconds(step_length)),
      mode(config.mode, can::seconds(step_length)),
      creep(creep_operators, can::seconds(step_length)) {
  if (config.second_mode) second_mode.emplace(config.second_mode->mode, can::seconds(step_length));
}

Plant::Plant(const Config& config, can::Time start)
    : config_(checked(config)),
      creep_(operators_of(config, model::OutputCreep(config.hysteresis_creep))),
      late_share_(1.0 - model::OutputCreep(config.hysteresis_creep).at_once()),
      material_(config.hysteresis, config.amplifier.safe_drive, remembered_branches),
      start_um_(material_.look_at(config.amplifier.safe_drive)),
      start_(start),
      substep_(config, creep_, config.substep),
      settled_{.time = start,
               .amplifier = {config.amplifier.safe_drive, config.amplifier.safe_drive},
               .hysteresis_um = start_um_,
               .creep_um = 0.0,
               .input_um = start_um_,
               .mode = {start_um_, 0.0},
               .second_mode = {start_um_, 0.0},
               .creep = model::Creep::settled(creep_, 0.0)},
      present_(settled_),
      next_grid_(start + config.substep) {}

void Plant::advance_to(can::Time time) {
  while (ramp_ && ramp_->turn.value_or(ramp_->end) <= time) pass_turn_or_end();
  go_on_to(time);
}

void Plant::pass_turn_or_end() {
  go_on_to(ramp_->turn.value_or(ramp_->end));
  if (ramp_->turn) {
    split();
    ramp_->turn.reset();
  } else {
    aim({.target = ramp_->to, .course = Amplifier::Course::drive});
    ramp_.reset();
  }
}

void Plant::go_on_to(can::Time time) {
  if (time <= present_.time) return;
  while (next_grid_ <= time) {
    const double output_before = settled_.amplifier.output;
    const can::Duration length = next_grid_ - settled_.time;
    move(settled_, step_of(length), [this](double drive) { return material_.go_to(drive); });
    const bool drive_rests =
        length >= config_.substep && !ramp_ && settled_.amplifier.output == output_before;
    if (drive_rests && has_settled())
      settled_.time += (time - settled_.time) / config_.substep * config_.substep;
    begin_substep(drive_rests && drifts_evenly() ? even_substeps * config_.substep : config_.substep);
  }
  present_ = settled_;
  if (time > settled_.time)
    move(present_, step_of(time - settled_.time), [this](double drive) { return material_.look_at(drive); });
}

double Plant::target_of(double drive) const {
  return std::clamp(Amplifier::target_of(config_.amplifier, drive), -disturbance_.most_drive,
                    disturbance_.most_drive);
}

void Plant::set_target(double drive, Amplifier::Course course) {
  const double target = target_of(drive);
  if (!ramp_ && target == present_.amplifier.target && course == present_.amplifier.course) return;
  aim({.target = target, .course = course});
  ramp_.reset();
}

void Plant::move_target(double drive, can::Duration time) {
  const double target = target_of(drive);
  const double change = target - present_.amplifier.target;
  if (change == 0.0 || time <= can::Duration::zero()) return set_target(drive);
  aim({.target = present_.amplifier.target,
       .course = Amplifier::Course::drive,
       .rate_per_s = change / can::seconds(time)});
  ramp_ = {.end = present_.time + time, .to = target, .turn = {}};
  const double turn_s =
      present_.amplifier.turns_after_s(Amplifier::limits(config_.amplifier), can::seconds(time));
  if (std::isfinite(turn_s))
    ramp_->turn = std::min(ramp_->end, present_.time + can::Duration(std::llround(1e9 * turn_s)));
}

/// From the present time on, the amplifier has the target of `at`, the target's rate of change, and the
/// course of `at` (how the output moves to the target). The output of the amplifier does not jump.
void Plant::aim(const Amplifier::State& at) {
  split();
  for (Motion* motion : {&settled_, &present_}) {
    motion->amplifier.target = at.target;
    motion->amplifier.course = at.course;
    motion->amplifier.rate_per_s = at.rate_per_s;
  }
}

void Plant::disturb(const Disturbance& disturbance) {
  if (!std::isfinite(disturbance.load_um))
    refuse("load_um = ", disturbance.load_um, ", expected a finite number");
  if (!std::isfinite(disturbance.gain)) refuse("gain = ", disturbance.gain, ", expected a finite number");
  if (!std::isfinite(disturbance.resonance) || disturbance.resonance <= 0.0)
    refuse("resonance = ", disturbance.resonance, ", expected a positive number");
  if (!(disturbance.most_drive >= 0.0))
    refuse("most_drive = ", disturbance.most_drive, ", expected at least 0");
  split();
  const double faster_by = disturbance.resonance / disturbance_.resonance;
  disturbance_ = disturbance;
  if (faster_by != 1.0) {
    config_.mode = faster(config_.mode, faster_by);
    if (config_.second_mode) config_.second_mode->mode = faster(config_.second_mode->mode, faster_by);
    substep_ = Step(config_, creep_, config_.substep);
    parts_.fill(std::nullopt);
  }
  settled_.input_um = present_.input_um = input_um(settled_);
  if (std::abs(present_.amplifier.target) > disturbance_.most_drive)
    set_target(present_.amplifier.target, present_.amplifier.course);
}

double Plant::crosstalk_um() const {
  double sum_um = 0.0;
  for (const auto& [from, um_per_um] : couplings_) {
    from->advance_to(present_.time);
    sum_um += um_per_um * (from->own_position_um(from->present_) - from->start_um_);
  }
  return sum_um;
}

// Advances `motion` by one step. `hysteresis` is a function from the drive to the output of the hysteresis,
// um.
template <class Hysteresis>
void Plant::move(Motion& motion, const Step& step, Hysteresis hysteresis) {
  motion.time += step.length;
  motion.amplifier = step.amplifier(motion.amplifier);
  const double hysteresis_before = motion.hysteresis_um;
  motion.hysteresis_um = hysteresis(motion.amplifier.output + noise_);
  if (!creep_.empty())
    motion.creep_um = step.creep(motion.creep, 0.5 * (hysteresis_before + motion.hysteresis_um) - start_um_);
  const double input_before = motion.input_um;
  motion.input_um = input_um(motion);
  motion.mode = step.mode(motion.mode, input_before, motion.input_um);
  if (step.second_mode)
    motion.second_mode = (*step.second_mode)(motion.second_mode, input_before, motion.input_um);
}

// Splits the present sub-step at the present time. The second part ends at the next grid point.
void Plant::split() {
  next_grid_ = start_ + ((present_.time - start_) / config_.substep + 1) * config_.substep;
  if (present_.time == settled_.time) return;
  material_.go_to(drive());
  settled_ = present_;
}

// Starts a sub-step of this length. Draws the noise of the drive for this sub-step and moves the material to
// the new drive. Then calls the handlers of on_grid().
void Plant::begin_substep(can::Duration length) {
  next_grid_ = settled_.time + length;
  if (drive_noise_) {
    noise_ = drive_noise_(settled_.time);
    settled_.hysteresis_um = material_.go_to(settled_.amplifier.output + noise_);
    settled_.input_um = input_um(settled_);
  }
  for (const GridHandler& handler : on_grid_) handler(settled_.time, own_position_um(settled_));
}

bool Plant::has_settled() {
  if (drive_noise_ || config_.temperature) return false;
  const double crept_um = settled_.hysteresis_um - start_um_;
  if (!std::ranges::all_of(settled_.creep, [&](double value) { return value == crept_um; })) return false;
  return settle(settled_.mode, config_.mode, settled_.input_um) &&
         (!config_.second_mode || settle(settled_.second_mode, config_.second_mode->mode, settled_.input_um));
}

// Returns true if creep and temperature move the stage so evenly that `even_substeps` sub-steps may be
// combined into one: the position then deviates from a straight line by at most negligible_um. The deviation
// of a curve from its chord is at most (second derivative) * (length of the step)^2 / 8. The second
// derivative is an upper bound, computed from the creep and the temperature.
bool Plant::drifts_evenly() const {
  constexpr double negligible_um = 1e-6;
  if (drive_noise_ || (creep_.empty() && !config_.temperature)) return false;
  double curvature_um_per_s2 = 0.0;
  for (std::size_t i = 0; i < creep_.size(); ++i) {
    const auto& [weight, rate_per_s, threshold] = creep_[i];
    const double to_go_um = settled_.hysteresis_um - start_um_ - settled_.creep[i];
    curvature_um_per_s2 += std::abs(weight * rate_per_s * rate_per_s * to_go_um);
  }
  if (config_.temperature) {
    const Temperature& t = *config_.temperature;
    const double omega = 2.0 * std::numbers::pi / t.period_s;
    const double travel_um = stroke_um(settled_) - start_um_;
    curvature_um_per_s2 +=
        omega * omega * std::abs(t.swing_K) *
        (std::abs(t.expansion_um_per_K) + std::abs(t.gain_per_K * disturbance_.gain * travel_um));
  }
  const double length_s = even_substeps * can::seconds(config_.substep);
  return curvature_um_per_s2 * length_s * length_s / 8.0 <= negligible_um &&
         std::abs(own_position_um(settled_) - settled_.input_um) <= negligible_um;
}

const Plant::Step& Plant::step_of(can::Duration length) {
  if (length == config_.substep) return substep_;
  std::optional<Step>& part = parts_[slot_of(length, parts_.size())];
  if (!part || part->length != length) part.emplace(config_, creep_, length);
  return *part;
}

double Plant::stroke_um(const Motion& motion) const {
  return motion.hysteresis_um + motion.creep_um - late_share_ * (motion.hysteresis_um - start_um_);
}

// Returns the input of the mechanical modes, um. Without a disturbance of the travel and without temperature,
// the gain of the travel is exactly 1. The term with the factor (gain - 1) is then exactly 0, so it adds no
// rounding error.
inline double Plant::input_um(const Motion& motion) const {
  double gain = disturbance_.gain;
  double offset_um = disturbance_.load_um;
  if (config_.temperature) {
    const Temperature& t = *config_.temperature;
    const double periods = can::seconds(motion.time - start_) / t.period_s;
    const double kelvin = t.swing_K * std::sin(2.0 * std::numbers::pi * periods);
    gain *= 1.0 + t.gain_per_K * kelvin;
    offset_um += t.expansion_um_per_K * kelvin;
  }
  const double stroke = stroke_um(motion);
  return stroke + (gain - 1.0) * (stroke - start_um_) + offset_um;
}

double Plant::own_position_um(const Motion& motion) const {
  if (!config_.second_mode) return motion.mode.position;
  const double share = config_.second_mode->share;
  return (1.0 - share) * motion.mode.position + share * motion.second_mode.position;
}

}  // namespace hystcan::twin
