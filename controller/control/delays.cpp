#include "controller/control/delays.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace hystcan::controller {

Moments Delays::moments(double cycle_s) const {
  constexpr double two_pi = 2.0 * std::numbers::pi;
  const double omega = two_pi * resonance_Hz;
  // A held drive has the delay and the variance of an average over one cycle. An interpolated drive is held
  // and then averaged over a cycle, so it counts as two such averages. `means`: number of averages.
  const double means = interpolated ? 2.0 : 1.0;
  return {.mean_s = std::chrono::duration<double>(command_delay).count() + means * cycle_s / 2.0 + lag_s() +
                    2.0 * damping_ratio / omega,
          .variance_s2 = means * cycle_s * cycle_s / 12.0 + lag_s() * lag_s() +
                         (4.0 * damping_ratio * damping_ratio - 2.0) / (omega * omega)};
}

double Delays::sensor_s() const {
  const double delay_s = std::chrono::duration<double>(sensor_delay).count();
  return sensor_bandwidth_Hz > 0.0 ? delay_s + 1.0 / (2.0 * std::numbers::pi * sensor_bandwidth_Hz) : delay_s;
}

namespace {

/// Returns tan(w T / 2), the prewarping of the notch. w is its angular frequency, T the cycle.
double warped(const Notch::Config& config, double cycle_s) {
  return std::tan(std::numbers::pi * config.frequency_Hz * cycle_s);
}

void require(bool met, const char* what, double value, const char* expected) {
  if (!met)
    throw std::invalid_argument(std::string("notch: ") + what + " is " + std::to_string(value) +
                                ", expected " + expected);
}

}  // namespace

Moments Notch::Config::moments(double cycle_s) const {
  const double theta_s = 0.5 * cycle_s / warped(*this, cycle_s);
  return {.mean_s = 2.0 * width * (1.0 - depth) * theta_s,
          .variance_s2 = 4.0 * width * width * (1.0 - depth * depth) * theta_s * theta_s};
}

Notch::Coefficients Notch::design(const Config& config, double cycle_s) {
  require(config.frequency_Hz > 0.0 && config.frequency_Hz * cycle_s < 0.5, "frequency_Hz",
          config.frequency_Hz, "more than 0 and less than half of rate_Hz");
  require(config.depth >= 0.0 && config.depth <= 1.0, "depth", config.depth, "0 to 1");
  require(config.width > 0.0 && std::isfinite(config.width), "width", config.width, "more than 0");
  const double t = warped(config, cycle_s);
  const double numerator = 2.0 * config.depth * config.width * t, denominator = 2.0 * config.width * t;
  const double scale = 1.0 / (1.0 + denominator + t * t);
  return {.b0 = (1.0 + numerator + t * t) * scale,
          .b1 = 2.0 * (t * t - 1.0) * scale,
          .b2 = (1.0 - numerator + t * t) * scale,
          .a1 = 2.0 * (t * t - 1.0) * scale,
          .a2 = (1.0 - denominator + t * t) * scale};
}

// Computes the output relative to the last output, so that a filter at rest stays exactly at rest. This uses
// the property of the coefficients that the gain at rest is 1:
//   b0 + b1 + b2 = 1 + a1 + a2
double Notch::step(const Coefficients& c, State& state, double input) {
  const double rest = state.output_1;
  const double output = rest + c.b0 * (input - rest) + c.b1 * (state.input_1 - rest) +
                        c.b2 * (state.input_2 - rest) - c.a2 * (state.output_2 - rest);
  state = {input, state.input_1, output, rest};
  return output;
}

double Notch::pass(State& state, double input) {
  state = {input, state.input_1, input, state.output_1};
  return input;
}

void Notch::shift(State& state, double by) {
  state.input_1 += by;
  state.input_2 += by;
  state.output_1 += by;
  state.output_2 += by;
}

Moments chain_moments(const Delays& delays, const std::optional<Notch::Config>& notch, double cycle_s) {
  const Moments moments = delays.moments(cycle_s);
  return notch ? moments + notch->moments(cycle_s) : moments;
}

double low_pass(double corner_Hz, double before, double input, double dt_s) {
  return before - std::expm1(-2.0 * std::numbers::pi * corner_Hz * dt_s) * (input - before);
}

double outside_deadband(double error, double deadband) {
  return error - std::clamp(error, -deadband, deadband);
}

}  // namespace hystcan::controller
