#include "controller/law.h"

#include <cmath>
#include <numbers>

#include "model/simplified.h"

namespace hystcan::controller {
namespace {

constexpr std::array<std::string_view, all_structures.size()> structure_names{"average", "inverse", "pi",
                                                                              "average+pi", "inverse+pi"};

model::HysteresisParameters what_to_invert(const ControlLaw::Config& config) {
  switch (config.structure) {
    case Structure::average:
    case Structure::average_pi:
      return model::average(config.model);
    case Structure::pi:
      return model::straight_line(config.model);
    case Structure::inverse:
    case Structure::inverse_pi:
      break;
  }
  return config.model;
}

/// Below this a demand counts as met: far under any sensor's resolution, far over the inverse's rounding.
constexpr double met_within_um = 1e-6;

}  // namespace

std::string_view to_string(Structure structure) {
  return structure_names[static_cast<std::size_t>(structure)];
}

std::optional<Structure> parse_structure(std::string_view text) {
  for (const Structure structure : all_structures)
    if (to_string(structure) == text) return structure;
  return std::nullopt;
}

double Delays::preview_s(double cycle_s) const {
  constexpr double two_pi = 2.0 * std::numbers::pi;
  return std::chrono::duration<double>(command_delay).count() + cycle_s / 2.0 +
         1.0 / (two_pi * amplifier_bandwidth_Hz) + 2.0 * damping_ratio / (two_pi * resonance_Hz);
}

ControlLaw::ControlLaw(const Config& config)
    : config_(config),
      feeds_forward_(config.structure != Structure::pi),
      feeds_back_(config.structure != Structure::average && config.structure != Structure::inverse),
      inverted_(what_to_invert(config)),
      memory_(inverted_.at_lower_threshold()) {}

double ControlLaw::restart_at_lower_threshold(double position_um) {
  inverted_.advance(memory_, inverted_.input_range().lo);
  error_um_ = 0.0;
  const double reference_um = feeds_back_ ? position_um : memory_.output;
  pi_.integral_um = feeds_back_ ? memory_.output - (feeds_forward_ ? reference_um : 0.0) : 0.0;
  return reference_um;
}

ControlLaw::Demand ControlLaw::propose(const Input& input) {
  integral_before_um_ = pi_.integral_um;
  if (input.position_um) {
    error_um_ = input.reference_um - *input.position_um;
    if (feeds_back_) pi_.integral_um += config_.pi.ki_per_s * error_um_ * input.dt_s;
  }
  demand_um_ = feeds_forward_ ? input.previewed_um : 0.0;
  if (feeds_back_) demand_um_ += config_.pi.kp * error_um_ + pi_.integral_um;

  const model::Prediction drive = inverted_.inverse(memory_, demand_um_);
  Demand demand{.drive = drive.value, .position_um = demand_um_};
  if (drive.saturated) demand.limits |= limit::model;
  if (!drive.increasing) demand.limits |= limit::not_invertible;
  return demand;
}

void ControlLaw::commit(double applied_drive) {
  inverted_.advance(memory_, applied_drive);
  const double unmet_um = demand_um_ - memory_.output;
  if (std::abs(unmet_um) > met_within_um && unmet_um * error_um_ > 0.0) pi_.integral_um = integral_before_um_;
}

}  // namespace hystcan::controller
