#include "controller/analysis/linear_loop.h"

#include <cmath>
#include <numbers>

namespace hystcan::controller {
namespace {

using Complex = std::complex<double>;

}  // namespace

LoopConfig loop_config_of(const ControlLaw::Config& law, const Delays& delays, double cycle_s) {
  return {.delays = delays,
          .cycle_s = cycle_s,
          .measurement_filter_Hz = law.measurement_filter_Hz,
          .notch = law.notch,
          .structure = law.structure};
}

Complex pi_response(const Pi::Config& pi, double cycle_s, double theta) {
  const Complex z = std::polar(1.0, theta);
  return pi.kp + pi.ki_per_s * cycle_s * z / (z - 1.0);
}

LinearLoop::LinearLoop(const LoopConfig& config, double longer_s)
    : config_(config), plant_(config.delays, config.cycle_s, longer_s) {
  if (config.notch) coefficients_ = Notch::design(*config.notch, config.cycle_s);
  if (config.measurement_filter_Hz > 0.0)
    filter_pole_ = std::exp(-2.0 * std::numbers::pi * config.measurement_filter_Hz * config.cycle_s);
}

Complex LinearLoop::notch(double theta) const {
  const Complex w = std::polar(1.0, -theta);
  const Notch::Coefficients& c = coefficients_;
  return (c.b0 + w * (c.b1 + w * c.b2)) / (1.0 + w * (c.a1 + w * c.a2));
}

Complex LinearLoop::plant(double theta) const { return notch(theta) * plant_.response(theta); }

Complex LinearLoop::filter(double theta) const {
  return (1.0 - filter_pole_) / (1.0 - filter_pole_ * std::polar(1.0, -theta));
}

Complex LinearLoop::without_gains(double theta) const { return filtered(theta, unfiltered(theta)); }

}  // namespace hystcan::controller
