#include "identification/dynamics/quasi_static.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "identification/dynamics/sampled_dataset.h"

namespace hystcan::identification {
namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;
constexpr double decayed = 14.0;  // time constants: to a millionth

// Rows of zeros that keep the end of the decay out of the beginning: the transform is periodic.
std::size_t padding(const model::Dynamics& dynamics, double cycle_s, std::size_t rows) {
  const double rate =
      std::min(dynamics.mode.damping_ratio, 1.0) * two_pi * dynamics.mode.natural_frequency_Hz;
  const double cycles = (decayed / std::max(rate, 1e-300) + dynamics.delay_s) / cycle_s;
  return cycles < static_cast<double>(rows) ? static_cast<std::size_t>(cycles) + 1 : rows;
}

std::complex<double> inverse_at(const model::HeldMode& mode, double theta) {
  const std::complex<double> response = mode.response(theta);
  return std::conj(response) / std::max(std::norm(response), 1.0);
}

}  // namespace

std::vector<double> respond(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                            const std::vector<double>& quasi_static) {
  const Grid grid = grid_of(time_s);
  model::DynamicOutput output(dynamics, grid.cycle_s, quasi_static.front());
  std::vector<double> positions;
  positions.reserve(quasi_static.size());
  Eigen::Index cycle = 0;
  for (std::size_t row = 0; row < quasi_static.size(); ++row, ++cycle) {
    for (; cycle < grid.cycles[row]; ++cycle) output.advance(quasi_static[row - 1]);
    positions.push_back(output.advance(quasi_static[row]));
  }
  return positions;
}

std::vector<double> before_dynamics(const model::Dynamics& dynamics, const std::vector<double>& time_s,
                                    const std::vector<double>& change) {
  const Grid grid = grid_of(time_s);
  const auto cycles = static_cast<std::size_t>(grid.length());
  std::size_t length = 2;
  while (length < cycles + padding(dynamics, grid.cycle_s, cycles)) length *= 2;
  std::vector<double> signal(length, 0.0);
  const Eigen::VectorXd held = held_on(grid, change);
  std::copy(held.begin(), held.end(), signal.begin());
  Eigen::FFT<double> transform;
  transform.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  std::vector<std::complex<double>> spectrum;
  transform.fwd(spectrum, signal);
  const model::HeldMode mode(dynamics.mode, dynamics.delay_s, grid.cycle_s);
  for (std::size_t k = 0; k < spectrum.size(); ++k)
    spectrum[k] *= inverse_at(mode, two_pi * static_cast<double>(k) / static_cast<double>(length));
  transform.inv(signal, spectrum, static_cast<Eigen::Index>(length));
  std::vector<double> rows;
  rows.reserve(change.size());
  for (const Eigen::Index cycle : grid.cycles) rows.push_back(signal[static_cast<std::size_t>(cycle)]);
  return rows;
}

}  // namespace hystcan::identification
