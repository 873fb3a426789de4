#include "controller/analysis/linear_loop.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
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

/// The formula of the plant's response needs different poles. If a pole is closer to another pole than
/// this share of its value, the pole is moved by twice this share. This changes the response by about the
/// same share.
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

constexpr double pi_ = std::numbers::pi;
constexpr double on_the_axis = -pi_ + 1e-9;  // -180 degrees, with a tolerance for rounding

/// Returns the argument between `a` and `b` at which `f` changes its sign.
double bisect(const std::function<double(double)>& f, double a, double b) {
  const bool sign = f(a) < 0.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (a + b);
    ((f(middle) < 0.0) == sign ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

double phase_margin_deg(const Complex& loop) { return std::abs(std::arg(-loop)) * 180.0 / pi_; }

/// Returns a positive value if the frequency is inside the bandwidth of the closed loop:
/// |L / (1 + L)|^2 > 1/2. L is `loop`, the response of the open loop.
double above_half_power(const Complex& loop) { return std::norm(loop) - 0.5 * std::norm(1.0 + loop); }

/// True if the loop is stable. `turned` is the angle of 1 + L at the highest frequency in rad, unwrapped from
/// the lowest frequency on; L is the open loop. In a stable loop this angle is 0, apart from rounding.
bool is_unturned(double turned) { return std::abs(turned) < 0.1; }

void require_gain(const char* name, double value) {
  if (!(value >= 0.0) || !std::isfinite(value))
    refuse(name, " = ", value, ", expected a number, zero or more");
}

/// Evaluates the open loop at ascending frequencies and collects its margins.
class FrequencySweep {
 public:
  FrequencySweep(const LinearLoop& loop, const PiGains& pi) : loop_(loop), pi_gains_(pi) {
    found_.phase_margin_deg = 180.0;
  }

  Margins along(const Eigen::ArrayXd& theta) {
    double before = theta[0];
    Complex was = at(before);
    double turned = std::arg(1.0 + was), phase = std::arg(was);
    look(was);
    for (Eigen::Index i = 1; i < theta.size(); ++i) {
      const Complex here = at(theta[i]);
      turned += std::arg((1.0 + here) / (1.0 + was));
      phase += std::arg(here / was);
      look(here);
      if (phase <= on_the_axis) found_.peak_beyond_180 = std::max(found_.peak_beyond_180, std::abs(here));
      look_between(before, was, theta[i], here);
      before = theta[i];
      was = here;
    }
    // At half the rate the response is real, so a negative response has a phase of 180 degrees.
    if (was.real() < 0.0) at_180_ = std::max(at_180_, std::abs(was));
    found_.peak_sensitivity = 1.0 / std::sqrt(least_distance_);
    found_.gain_margin = at_180_ > 0.0 ? 1.0 / at_180_ : std::numeric_limits<double>::infinity();
    found_.stable = is_unturned(turned);
    return found_;
  }

 private:
  Complex at(double theta) const { return loop_(pi_gains_, theta); }
  double in_Hz(double theta) const { return theta / (2.0 * pi_ * loop_.config().cycle_s); }

  void look(const Complex& here) { least_distance_ = std::min(least_distance_, std::norm(1.0 + here)); }

  void look_between(double before, const Complex& was, double theta, const Complex& here) {
    if ((std::norm(was) >= 1.0) != (std::norm(here) >= 1.0)) {
      const double crossover = bisect([&](double t) { return std::abs(at(t)) - 1.0; }, before, theta);
      if (found_.crossover_Hz == 0.0) found_.crossover_Hz = in_Hz(crossover);
      found_.phase_margin_deg = std::min(found_.phase_margin_deg, phase_margin_deg(at(crossover)));
    }
    if (was.imag() * here.imag() < 0.0 && std::min(was.real(), here.real()) < 0.0) {
      const Complex crossing = at(bisect([&](double t) { return at(t).imag(); }, before, theta));
      if (crossing.real() < 0.0) at_180_ = std::max(at_180_, std::abs(crossing));
    }
    if (found_.bandwidth_Hz == 0.0 && above_half_power(was) >= 0.0 && above_half_power(here) < 0.0)
      found_.bandwidth_Hz = in_Hz(bisect([&](double t) { return above_half_power(at(t)); }, before, theta));
  }

  const LinearLoop& loop_;
  PiGains pi_gains_;
  Margins found_;
  double least_distance_ = std::numeric_limits<double>::infinity();  ///< minimum of |1 + L|^2; L: open loop
  double at_180_ = 0.0;  ///< largest gain of the open loop at a phase of 180 degrees
};

/// Returns Margins::stable for these gains. `of` contains the response of the loop without its gains, so a
/// search over many gains is fast.
bool is_stable(const Responses& of, double kp, double ki_per_cycle) {
  const auto from_minus_one = [&](Eigen::Index i) {
    return 1.0 + ki_per_cycle * of.integral[i] + kp * of.proportional[i];
  };
  Complex was = from_minus_one(0);
  double turned = std::arg(was);
  for (Eigen::Index i = 1; i < of.integral.size(); ++i) {
    const Complex here = from_minus_one(i);
    turned += std::arg(here / was);
    was = here;
  }
  return is_unturned(turned);
}

/// Returns the largest stable value between `least` and `unstable`, rounded down to two digits. Bisects the
/// logarithm of the value. Returns `nullopt` if `least` is not stable.
std::optional<double> largest(const std::function<bool(double)>& stable, double least, double unstable) {
  if (!stable(least)) return std::nullopt;
  double lo = std::log(least), hi = std::log(unstable);
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (lo + hi);
    (stable(std::exp(middle)) ? lo : hi) = middle;
  }
  const double value = std::exp(lo), unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::floor(value / unit) * unit;
}

}  // namespace

PlantRecursion::Config held_plant(const Delays& delays, double cycle_s, double longer_s) {
  require_positive("cycle_s", cycle_s);
  const std::vector<Complex> poles = poles_of(delays);
  const double delay_s = delays.pure_s() + longer_s;
  if (!std::isfinite(delay_s) || std::abs(delay_s) > 1e6 * cycle_s)
    refuse("delay_s = ", delay_s, ", expected less than a million cycles");
  constexpr double rounding = 1e-9;  // tolerance: a delay of whole cycles stays whole
  const double cycles = std::ceil(delay_s / cycle_s - rounding);  // delay in cycles, rounded up
  const double rest_s = cycles * cycle_s - delay_s;  // time from the delay to the next whole cycle
  PlantRecursion::Config plant;
  plant.delay_cycles = static_cast<int>(cycles);
  plant.interpolated = delays.interpolated;
  plant.constant = rest_s / cycle_s;
  for (std::size_t i = 0; i < poles.size(); ++i) {
    Complex share = -1.0;  // coefficient c_i of the pole in the step response (linear_loop.h)
    for (std::size_t k = 0; k < poles.size(); ++k)
      if (k != i) share *= poles[k] / (poles[k] - poles[i]);
    if (plant.interpolated) {
      share /= poles[i] * cycle_s;
      plant.constant -= share.real();  // the imaginary parts of conjugate poles cancel
    }
    plant.terms[i] = {share * std::exp(poles[i] * rest_s), std::exp(poles[i] * cycle_s)};
  }
  return plant;
}

Complex response_of(const PlantRecursion::Config& plant, double theta) {
  const Complex w = std::polar(1.0, -theta);
  Complex sum = 0.0;
  for (const PlantRecursion::Term& term : plant.terms) sum += term.share / (1.0 - term.decay * w);
  const Complex late = std::polar(1.0, -theta * plant.delay_cycles);
  if (!plant.interpolated) return late * (1.0 + (1.0 - w) * sum);
  return late * (w + (1.0 - w) * (plant.constant + (1.0 - w) * sum));
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

LoopConfig loop_config_of(const ControlLaw::Config& law, const Delays& delays, double cycle_s) {
  return {.delays = delays,
          .cycle_s = cycle_s,
          .pi = law.pi,
          .measurement_filter_Hz = law.measurement_filter_Hz,
          .notch = law.notch,
          .structure = law.structure};
}

Complex pi_response(const PiGains& pi, double cycle_s, double theta) {
  const Complex z = std::polar(1.0, theta);
  return pi.kp + pi.ki_per_s * cycle_s * z / (z - 1.0);
}

LinearLoop::LinearLoop(const LoopConfig& config, double longer_s)
    : config_(config), plant_(held_plant(config.delays, config.cycle_s, longer_s)) {
  if (config.notch) coefficients_ = Notch::design(*config.notch, config.cycle_s);
  if (config.measurement_filter_Hz > 0.0)
    filter_pole_ = std::exp(-2.0 * std::numbers::pi * config.measurement_filter_Hz * config.cycle_s);
}

Complex LinearLoop::notch(double theta) const {
  const Complex w = std::polar(1.0, -theta);
  const Notch::Coefficients& c = coefficients_;
  return (c.b0 + w * (c.b1 + w * c.b2)) / (1.0 + w * (c.a1 + w * c.a2));
}

Complex LinearLoop::plant(double theta) const { return notch(theta) * unfiltered(theta); }

Complex LinearLoop::filter(double theta) const {
  return (1.0 - filter_pole_) / (1.0 - filter_pole_ * std::polar(1.0, -theta));
}

Complex LinearLoop::without_gains(double theta) const { return filtered(theta, unfiltered(theta)); }

Eigen::ArrayXd frequencies_for(const LoopConfig& config, double density) {
  const int even = static_cast<int>(1000 * density), slow = static_cast<int>(3000 * density),
            close = static_cast<int>(300 * density);
  std::vector<double> theta;
  for (int i = 1; i <= even; ++i) theta.push_back(pi_ * i / even);
  for (int i = 0; i < slow; ++i) theta.push_back(pi_ * std::pow(10.0, -4.0 + 4.0 * i / slow));
  constexpr int per_decade = 10;  // a few are enough: no practical loop has its crossover here
  for (int i = 0; i < 3 * per_decade; ++i) theta.push_back(pi_ * std::pow(10.0, -7.0 + 1.0 * i / per_decade));
  const double omega = 2.0 * pi_ * config.delays.resonance_Hz * config.cycle_s;
  for (int i = -close; i <= close; ++i) {
    const double width = omega * std::max(config.delays.damping_ratio, 1e-6);
    const double seen = std::remainder(omega + width * std::sinh(5.0 * i / close), 2.0 * pi_);
    if (seen != 0.0) theta.push_back(std::abs(seen));
  }
  std::ranges::sort(theta);
  return Eigen::Map<const Eigen::ArrayXd>(theta.data(), static_cast<Eigen::Index>(theta.size()));
}

Responses responses_of(const LinearLoop& loop) {
  const Eigen::ArrayXd theta = frequencies_for(loop.config());
  const Eigen::ArrayXcd plant = theta.unaryExpr([&](double t) { return loop.without_gains(t); });
  const Eigen::ArrayXcd integral = plant * theta.unaryExpr([](double t) {
    const Complex z = std::polar(1.0, t);
    return z / (z - 1.0);
  });
  return {integral, plant};
}

Margins margins_of(const LinearLoop& loop, const PiGains& pi) {
  require_gain("ki_per_s", pi.ki_per_s);
  require_gain("kp", pi.kp);
  return FrequencySweep(loop, pi).along(frequencies_for(loop.config()));
}

Margins worse_of(const Margins& a, const Margins& b) {
  return {.stable = a.stable && b.stable,
          .phase_margin_deg = std::min(a.phase_margin_deg, b.phase_margin_deg),
          .gain_margin = std::min(a.gain_margin, b.gain_margin),
          .peak_beyond_180 = std::max(a.peak_beyond_180, b.peak_beyond_180),
          .peak_sensitivity = std::max(a.peak_sensitivity, b.peak_sensitivity),
          .crossover_Hz = std::min(a.crossover_Hz, b.crossover_Hz),
          .bandwidth_Hz = std::min(a.bandwidth_Hz, b.bandwidth_Hz)};
}

PiGains largest_stable_gains(const LinearLoop& loop, const PiGains& pi) {
  constexpr double least_share = 1e-9;
  require_gain("kp", pi.kp);
  const double cycle_s = loop.config().cycle_s, most_ki_per_s = std::max(pi.ki_per_s, 10.0 / cycle_s);
  const Responses of = responses_of(loop);
  const auto with_ki = [&](double ki_per_s) { return is_stable(of, pi.kp, ki_per_s * cycle_s); };
  if (const auto ki_per_s = largest(with_ki, least_share * most_ki_per_s, most_ki_per_s))
    return {.kp = pi.kp, .ki_per_s = *ki_per_s};
  const auto with_kp = [&](double kp) { return is_stable(of, kp, 0.0); };
  return {.kp = largest(with_kp, least_share, std::max(pi.kp, 10.0)).value_or(0.0)};
}

}  // namespace hystcan::controller
