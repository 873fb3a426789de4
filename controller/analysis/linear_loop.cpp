#include "controller/analysis/linear_loop.h"

#include <cmath>
#include <numbers>

namespace hystcan::controller {
namespace {

using Complex = std::complex<double>;

/// V(e^{i theta}) of second_order_preview() and of the plain look-up.
Complex preview_response(const Moments& moments, bool second_order, double cycle_s, double theta) {
  const Complex ahead = std::polar(1.0, theta * moments.mean_s / cycle_s);
  if (!second_order) return ahead;
  return ahead * (1.0 - moments.variance_s2 / (cycle_s * cycle_s) * (std::cos(theta) - 1.0));
}

}  // namespace

LoopConfig loop_config_of(const ControlLaw::Config& law, const Delays& delays, double cycle_s) {
  return {.delays = delays,
          .cycle_s = cycle_s,
          .measurement_filter_Hz = law.measurement_filter_Hz,
          .notch = law.notch};
}

Complex pi_response(const Pi::Config& pi, double cycle_s, double theta) {
  const Complex z = std::polar(1.0, theta);
  return pi.kp + pi.ki_per_s * cycle_s * z / (z - 1.0);
}

LinearLoop::LinearLoop(const LoopConfig& config, double longer_s)
    : config_(config),
      plant_(config.delays, config.cycle_s, longer_s),
      moments_(chain_moments(config.delays, config.notch, config.cycle_s)) {
  if (config.notch) notch_ = Notch::design(*config.notch, config.cycle_s);
  if (config.measurement_filter_Hz > 0.0)
    filter_pole_ = std::exp(-2.0 * std::numbers::pi * config.measurement_filter_Hz * config.cycle_s);
}

Complex LinearLoop::plant(double theta) const {
  const Complex w = std::polar(1.0, -theta);
  const Notch::Coefficients& c = notch_;
  const Complex notch = (c.b0 + w * (c.b1 + w * c.b2)) / (1.0 + w * (c.a1 + w * c.a2));
  return notch * plant_.response(theta);
}

Complex LinearLoop::filter(double theta) const {
  return (1.0 - filter_pole_) / (1.0 - filter_pole_ * std::polar(1.0, -theta));
}

Complex LinearLoop::without_gains(double theta) const { return filter(theta) * plant(theta); }

Complex LinearLoop::tracking(const Pi::Config& pi, double theta) const {
  const Complex feedback = pi_response(pi, config_.cycle_s, theta) * filter(theta), path = plant(theta);
  const Complex ahead = preview_response(moments_, config_.delays.second_order, config_.cycle_s, theta);
  const Complex late = std::polar(1.0, -theta * config_.delays.sensor_s() / config_.cycle_s);
  return path * (ahead + feedback * late) / (1.0 + feedback * path);
}

}  // namespace hystcan::controller
