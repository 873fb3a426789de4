#include "identification/dynamics/pi_rule.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "model/refusal.h"

namespace hystcan::identification {
namespace {

using Complex = std::complex<double>;
constexpr double pi = std::numbers::pi;
constexpr double on_the_axis = -pi + 1e-9;  // with room for rounding

/// A grid of even steps, logarithmic steps (0.3 %) for slow loops, and a cluster around the (aliased)
/// resonance.
Eigen::ArrayXd frequencies(const model::SecondOrder::Config& mode, double cycle_s) {
  std::vector<double> theta;
  for (int i = 1; i <= 1000; ++i) theta.push_back(pi * i / 1000);
  for (int i = 0; i < 3000; ++i) theta.push_back(pi * std::pow(10.0, -4.0 + 4.0 * i / 3000));
  const double omega = 2.0 * pi * mode.natural_frequency_Hz * cycle_s;
  for (int i = -300; i <= 300; ++i) {
    const double width = omega * std::max(mode.damping_ratio, 1e-6);
    const double seen = std::remainder(omega + width * std::sinh(i / 60.0), 2.0 * pi);
    if (seen != 0.0) theta.push_back(std::abs(seen));
  }
  std::ranges::sort(theta);
  return Eigen::Map<const Eigen::ArrayXd>(theta.data(), static_cast<Eigen::Index>(theta.size()));
}

/// z / (z - 1)
Complex integrator(double theta) {
  const Complex z = std::polar(1.0, theta);
  return z / (z - 1.0);
}

/// The place between `a` and `b` where `f` changes its sign.
double bisect(const std::function<double(double)>& f, double a, double b) {
  const bool sign = f(a) < 0.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (a + b);
    ((f(middle) < 0.0) == sign ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

double phase_margin_deg(const Complex& loop) { return std::abs(std::arg(-loop)) * 180.0 / pi; }

/// The value with three significant digits, rounded towards zero.
double rounded_down(double value) {
  if (value <= 0.0) return 0.0;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
  const double steps = std::floor(value / unit * (1.0 + 1e-12));
  return unit < 1.0 ? steps / std::round(1.0 / unit) : steps * unit;
}

/// The largest factor of `shape` (the loop at ki T = 1) that satisfies the rule.
double largest_factor(const Eigen::ArrayXcd& shape, const PiRule& rule) {
  const double limit = rule.phase_margin_deg * pi / 180.0 - pi;
  double phase = std::arg(shape[0]), worst = 1e-300;
  for (Eigen::Index i = 0; i < shape.size(); ++i) {
    if (i > 0) phase += std::arg(shape[i] / shape[i - 1]);
    if (phase <= limit) worst = std::max(worst, std::abs(shape[i]));
    if (phase <= on_the_axis) worst = std::max(worst, rule.gain_margin * std::abs(shape[i]));
  }
  return 1.0 / worst;
}

}  // namespace

SampledLoop::SampledLoop(const model::SecondOrder::Config& mode, double delay_s, double cycle_s,
                         int command_cycles)
    : plant_(mode, delay_s, cycle_s),
      cycle_s_(cycle_s),
      command_cycles_(command_cycles),
      theta_(frequencies(mode, cycle_s)) {
  if (command_cycles < 0) model::refuse("command_cycles = ", command_cycles, ", expected zero or more");
  response_ = theta_.unaryExpr(
      [&](double theta) { return std::polar(1.0, -theta * command_cycles) * plant_.response(theta); });
}

Complex SampledLoop::operator()(const PiGains& gains, double theta) const {
  return (gains.kp + gains.ki_per_s * cycle_s_ * integrator(theta)) *
         std::polar(1.0, -theta * command_cycles_) * plant_.response(theta);
}

Margins SampledLoop::margins(const PiGains& gains) const {
  if (!(gains.ki_per_s > 0.0) || !std::isfinite(gains.ki_per_s))
    model::refuse("ki_per_s = ", gains.ki_per_s, ", expected a positive number");
  if (!(gains.kp >= 0.0) || !std::isfinite(gains.kp))
    model::refuse("kp = ", gains.kp, ", expected a number, zero or more");
  const auto loop = [&](double theta) { return (*this)(gains, theta); };
  const auto gain = [&](double theta) { return std::abs(loop(theta)) - 1.0; };
  const auto sine = [&](double theta) { return loop(theta).imag(); };
  const auto tracking = [&](double theta) {
    return std::abs(loop(theta) / (1.0 + loop(theta))) - std::numbers::sqrt2 / 2.0;
  };
  const double per_theta_Hz = 1.0 / (2.0 * pi * cycle_s_);
  Margins margins;
  margins.phase_margin_deg = 180.0;
  double at_180 = 0.0;  // the largest |L| at which L is real and negative
  double turned =
      std::arg(1.0 + loop(theta_[0])) + pi / 2;  // arg(1 + L), from the -90 degrees of an integrator
  double phase = std::arg(loop(theta_[0]));
  for (Eigen::Index i = 0; i < theta_.size(); ++i) {
    const double theta = theta_[i];
    const Complex here = loop(theta);
    margins.peak_sensitivity = std::max(margins.peak_sensitivity, 1.0 / std::abs(1.0 + here));
    if (i == 0) continue;
    const double before = theta_[i - 1];
    const Complex was = loop(before);
    turned += std::arg((1.0 + here) / (1.0 + was));
    phase += std::arg(here / was);
    if (phase <= on_the_axis) margins.peak_beyond_180 = std::max(margins.peak_beyond_180, std::abs(here));
    if ((std::abs(was) >= 1.0) != (std::abs(here) >= 1.0)) {
      const double crossover = bisect(gain, before, theta);
      if (margins.crossover_Hz == 0.0) margins.crossover_Hz = crossover * per_theta_Hz;
      margins.phase_margin_deg = std::min(margins.phase_margin_deg, phase_margin_deg(loop(crossover)));
    }
    if (was.imag() * here.imag() < 0.0 && std::min(was.real(), here.real()) < 0.0) {
      const Complex crossing = loop(bisect(sine, before, theta));
      if (crossing.real() < 0.0) at_180 = std::max(at_180, std::abs(crossing));
    }
    if (margins.bandwidth_Hz == 0.0 && tracking(theta) < 0.0)
      margins.bandwidth_Hz = bisect(tracking, before, theta) * per_theta_Hz;
  }
  const Complex last = loop(pi);  // real
  if (last.real() < 0.0) at_180 = std::max(at_180, std::abs(last));
  margins.gain_margin = at_180 > 0.0 ? 1.0 / at_180 : std::numeric_limits<double>::infinity();
  margins.stable = std::abs(turned - pi / 2) < 0.1;
  return margins;
}

PiGains SampledLoop::suggest(const PiRule& rule) const {
  if (!(rule.phase_margin_deg > 0.0 && rule.phase_margin_deg < 90.0))
    model::refuse("phase_margin_deg = ", rule.phase_margin_deg, ", expected more than 0 and less than 90");
  if (!(rule.gain_margin > 1.0)) model::refuse("gain_margin = ", rule.gain_margin, ", expected more than 1");
  const Eigen::ArrayXcd integral = response_ * theta_.unaryExpr(&integrator);
  PiGains best;
  for (int i = 0; i <= 250; ++i) {
    const double kp_per_ki = 0.02 * i;  // cycles
    const double ki_per_cycle = largest_factor(integral + kp_per_ki * response_, rule);
    if (ki_per_cycle <= best.ki_per_s * cycle_s_) continue;
    best = {kp_per_ki * ki_per_cycle, ki_per_cycle / cycle_s_};
  }
  return {rounded_down(best.kp), rounded_down(best.ki_per_s)};
}

}  // namespace hystcan::identification
