#include "controller/analysis/feed_forward_design.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "controller/analysis/linear_loop.h"

namespace hystcan::controller {
namespace {

using Complex = std::complex<double>;

constexpr int reach = feed_forward_reach, weights = 2 * reach + 1;
using Weights = Eigen::Vector<double, weights>;
constexpr int design_grid = 400;     ///< number of frequencies theta in the design, up to pi (half the rate)
constexpr double flat_below = 0.03;  ///< frequency theta below which the weight of errors is nearly constant
constexpr int aliases = 6;           ///< number of aliases on each side of a frequency in the design

/// Returns the response from the setpoints to the position at the m-th alias of the frequency `theta`, with
/// notch and command delay.
Complex path_of(const LoopConfig& loop, const Complex& notch, double theta, int m) {
  const double frequency_Hz = (theta / (2.0 * std::numbers::pi) + m) / loop.cycle_s;
  const double delay_s = std::chrono::duration<double>(loop.delays.command_delay).count();
  return notch * response_between_samples(loop.delays, loop.cycle_s, frequency_Hz) *
         std::polar(1.0, -2.0 * std::numbers::pi * frequency_Hz * delay_s);
}

/// Returns the weights of the feed-forward, which minimise the integral over theta of
///
///   W(theta) [|1 - P_0 V|^2 + sum_m |P_m V|^2],   m = -6 .. 6 without 0
///
///   V     response of the feed-forward        P_0   response from the setpoints to the position
///   W     weight of the frequency theta       P_m   the same at the m-th alias of theta
///
/// The weights solve the normal equations with two conditions: their sum is 1, and the times at which they
/// take the reference have the plant's mean delay as their weighted mean.
Weights feed_forward_weights(const LoopConfig& loop, const LinearLoop& linear) {
  const double ahead = chain_moments(loop.delays, loop.notch, loop.cycle_s).mean_s / loop.cycle_s;
  Eigen::Matrix<double, weights + 2, weights + 2> normal =
      Eigen::Matrix<double, weights + 2, weights + 2>::Zero();
  Eigen::Vector<double, weights + 2> right = Eigen::Vector<double, weights + 2>::Zero();
  for (int i = 1; i <= design_grid; ++i) {
    const double theta = std::numbers::pi * i / design_grid;
    const Complex notch = linear.notch(theta), path = path_of(loop, notch, theta, 0);
    double rings = 0.0;
    for (int m = 1; m <= aliases; ++m)
      rings += std::norm(path_of(loop, notch, theta, m)) + std::norm(path_of(loop, notch, theta, -m));
    const double share = 1.0 / std::pow(theta * theta + flat_below * flat_below, 2);
    Eigen::Vector<Complex, weights> shifts;
    for (int k = 0; k < weights; ++k) shifts[k] = std::polar(1.0, theta * (ahead + k - reach));
    normal.topLeftCorner<weights, weights>() +=
        share * (std::norm(path) + rings) * (shifts.conjugate() * shifts.transpose()).real();
    right.head<weights>() += share * (std::conj(path) * shifts.conjugate()).real();
  }
  for (int k = 0; k < weights; ++k) {
    normal(weights, k) = normal(k, weights) = 1.0;
    normal(weights + 1, k) = normal(k, weights + 1) = k - reach;
  }
  right[weights] = 1.0;
  return normal.fullPivLu().solve(right).head<weights>();
}

/// Returns the smallest number of periods whose duration is a whole number of cycles. Returns 0 if there is
/// none up to 100.
unsigned whole_periods(double cycles_per_period) {
  constexpr unsigned most = 100;
  for (unsigned periods = 1; periods <= most; ++periods) {
    const double cycles = periods * cycles_per_period;
    if (std::round(cycles) >= 1.0 && std::abs(cycles - std::round(cycles)) < 1e-6) return periods;
  }
  return 0;
}

/// Three sums over all harmonics of the position that one frequency of the setpoints affects: the frequency
/// itself and its aliases. R: harmonic of the reference; P: response from the setpoints to the position. The
/// smallest error of these harmonics has the mean square `reference` - |`reached`|^2 / `gain`.
struct AliasSums {
  double reference = 0.0;              ///< sum of |R|^2 over these harmonics (R: reference)
  std::complex<double> reached = 0.0;  ///< sum of conj(P) R over these harmonics (P: response, R: reference)
  double gain = 0.0;                   ///< sum of |P|^2 over these harmonics (P: response)
};

}  // namespace

PlantInverse::Config design_plant_inverse(const LoopConfig& loop) {
  PlantInverse::Config inverse{.feed_forward = {}, .plant = held_plant(loop.delays, loop.cycle_s)};
  if (loop.notch) inverse.plant.notch = Notch::design(*loop.notch, loop.cycle_s);
  const Weights found = feed_forward_weights(loop, LinearLoop(loop));
  for (int k = 0; k < weights; ++k) inverse.feed_forward[static_cast<std::size_t>(k)] = found[k];
  return inverse;
}

void plan_feed_forward(AxisConfig& axis, double rate_Hz) {
  axis.plant_inverse.reset();
  if (axis.delays.plant_inverse)
    axis.plant_inverse = design_plant_inverse(loop_config_of(axis.law, axis.delays, 1.0 / rate_Hz));
}

double tracking_floor_um(const Delays& delays, double cycle_s, std::size_t cycles,
                         const std::function<double(double t_s)>& reference_um) {
  constexpr double fine_s = 1e-5;
  const auto per_cycle = static_cast<std::size_t>(std::max(16.0, std::round(cycle_s / fine_s)));
  const std::size_t values = cycles * per_cycle;
  std::vector<double> reference(values);
  for (std::size_t i = 0; i < values; ++i)
    reference[i] = reference_um(static_cast<double>(i) * cycle_s / static_cast<double>(per_cycle));
  std::vector<std::complex<double>> spectrum;
  Eigen::FFT<double>().fwd(spectrum, reference);

  std::vector<AliasSums> sums(cycles);
  for (std::size_t i = 0; i < values; ++i) {
    const double harmonic = static_cast<double>(i) - (2 * i < values ? 0.0 : static_cast<double>(values));
    const std::complex<double> r = spectrum[i] / static_cast<double>(values);
    const std::complex<double> p =
        response_between_samples(delays, cycle_s, harmonic / (static_cast<double>(cycles) * cycle_s));
    AliasSums& sum = sums[i % cycles];
    sum.reference += std::norm(r);
    sum.reached += std::conj(p) * r;
    sum.gain += std::norm(p);
  }
  double square_um2 = 0.0;
  for (const AliasSums& sum : sums) square_um2 += sum.reference - std::norm(sum.reached) / sum.gain;
  return std::sqrt(std::max(square_um2, 0.0));
}

std::optional<double> tracking_floor_um(const Delays& delays, double cycle_s, const Shape& shape) {
  const auto of_periods = [&](auto repeating) -> std::optional<double> {
    const double cycles_per_period = 1.0 / (repeating.frequency_Hz * cycle_s);
    const unsigned periods = whole_periods(cycles_per_period);
    if (periods == 0) return std::nullopt;
    repeating.cycles = periods;
    const Shape whole = repeating;
    return tracking_floor_um(delays, cycle_s,
                             static_cast<std::size_t>(std::llround(periods * cycles_per_period)),
                             [&](double t_s) { return value_um(whole, t_s); });
  };
  if (const auto* triangle = std::get_if<Triangle>(&shape)) return of_periods(*triangle);
  if (const auto* sine = std::get_if<Sine>(&shape)) return of_periods(*sine);
  return std::nullopt;
}

}  // namespace hystcan::controller
