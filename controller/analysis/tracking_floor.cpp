#include "controller/analysis/tracking_floor.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "controller/analysis/held_plant.h"

namespace hystcan::controller {
namespace {

/// The least number of periods that is a whole number of cycles; 0 where there is none.
unsigned whole_periods(double cycles_per_period) {
  constexpr unsigned most = 100;
  for (unsigned periods = 1; periods <= most; ++periods) {
    const double cycles = periods * cycles_per_period;
    if (std::round(cycles) >= 1.0 && std::abs(cycles - std::round(cycles)) < 1e-6) return periods;
  }
  return 0;
}

struct AliasSums {
  double reference = 0.0;              ///< sum |R|^2
  std::complex<double> reached = 0.0;  ///< sum conj(P) R
  double gain = 0.0;                   ///< sum |P|^2
};

}  // namespace

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
