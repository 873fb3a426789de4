#include "controller/analysis/linear_loop.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "base/text.h"

namespace hystcan::controller {
namespace {

using Complex = std::complex<double>;
constexpr double whole_turn = 2.0 * std::numbers::pi;

void require_positive(const char* name, double value) {
  if (!(value > 0.0) || !std::isfinite(value)) refuse(name, " = ", value, ", expected a positive number");
}

/// The formula needs poles apart from each other. A pole that meets another one is moved by this share, which
/// changes the response by as little.
constexpr double apart = 1e-5;

void add_pole(std::vector<Complex>& poles, Complex pole) {
  for (const Complex& other : poles)
    if (std::abs(pole - other) < apart * std::abs(pole)) pole *= 1.0 + 2.0 * apart;
  poles.push_back(pole);
}

std::vector<Complex> poles_of(const Delays& delays) {
  require_positive("resonance_Hz", delays.resonance_Hz);
  require_positive("amplifier_bandwidth_Hz", delays.amplifier_bandwidth_Hz);
  if (!(delays.damping_ratio >= 0.0) || !std::isfinite(delays.damping_ratio))
    refuse("damping_ratio = ", delays.damping_ratio, ", expected a number, zero or more");
  const double omega = whole_turn * delays.resonance_Hz, zeta = delays.damping_ratio;
  const Complex root = std::sqrt(Complex(zeta * zeta - 1.0));
  std::vector<Complex> poles;
  add_pole(poles, omega * (-zeta + root));
  add_pole(poles, omega * (-zeta - root));
  add_pole(poles, -whole_turn * delays.amplifier_bandwidth_Hz);
  if (delays.sensor_bandwidth_Hz > 0.0) add_pole(poles, -whole_turn * delays.sensor_bandwidth_Hz);
  return poles;
}

}  // namespace

HeldPlant::HeldPlant(const Delays& delays, double cycle_s, double longer_s) {
  require_positive("cycle_s", cycle_s);
  const std::vector<Complex> poles = poles_of(delays);
  const double delay_s = delays.pure_s() + longer_s;
  if (!std::isfinite(delay_s) || std::abs(delay_s) > 1e6 * cycle_s)
    refuse("delay_s = ", delay_s, ", expected less than a million cycles");
  constexpr double rounding = 1e-9;                               // a delay of whole cycles in nanoseconds
  const double cycles = std::ceil(delay_s / cycle_s - rounding);  // j
  const double rest_s = cycles * cycle_s - delay_s;               // tau
  plant_.delay_cycles = static_cast<int>(cycles);
  plant_.interpolated = delays.interpolated;
  plant_.constant = rest_s / cycle_s;
  for (std::size_t i = 0; i < poles.size(); ++i) {
    Complex share = -1.0;  // c_i
    for (std::size_t k = 0; k < poles.size(); ++k)
      if (k != i) share *= poles[k] / (poles[k] - poles[i]);
    if (plant_.interpolated) {
      share /= poles[i] * cycle_s;
      plant_.constant -= share.real();  // the imaginary parts of a pair add up to zero
    }
    plant_.terms[i] = {share * std::exp(poles[i] * rest_s), std::exp(poles[i] * cycle_s)};
  }
}

std::complex<double> HeldPlant::response(double theta) const {
  const Complex w = std::polar(1.0, -theta);
  Complex sum = 0.0;
  for (const PlantRecursion::Term& term : plant_.terms) sum += term.share / (1.0 - term.decay * w);
  const Complex late = std::polar(1.0, -theta * plant_.delay_cycles);
  if (!plant_.interpolated) return late * (1.0 + (1.0 - w) * sum);
  return late * (w + (1.0 - w) * (plant_.constant + (1.0 - w) * sum));
}

Complex response_between_samples(const Delays& delays, double cycle_s, double frequency_Hz) {
  const Complex s(0.0, whole_turn * frequency_Hz);
  const Complex u = s / (whole_turn * delays.resonance_Hz);
  const Complex st = s * cycle_s;
  const Complex held = frequency_Hz == 0.0 ? 1.0 : (1.0 - std::exp(-st)) / st;
  return (delays.interpolated ? held * held : held) /
         (1.0 + s / (whole_turn * delays.amplifier_bandwidth_Hz)) /
         (1.0 + 2.0 * delays.damping_ratio * u + u * u);
}

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
