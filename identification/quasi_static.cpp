#include "identification/quasi_static.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "base/text.h"
#include "identification/identify.h"

namespace hystcan::identification {

std::vector<double> with_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                               std::vector<double> outputs,
                               const std::optional<model::HeldCreep::State>& start) {
  if (creep.lags() == 0) return outputs;
  model::HeldCreep rows(creep, start);
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    rows.hold_until(time_s[i]);
    outputs[i] = rows.follow(outputs[i]);
  }
  return outputs;
}

std::vector<double> without_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                                  std::vector<double> outputs, const std::vector<bool>& counts) {
  if (creep.lags() == 0) return outputs;
  constexpr double as_long = 1e-9;  // time steps whose relative difference is smaller count as equally long
  const std::vector<double>& rates_per_s = creep.rates_per_s();
  model::OutputCreep::State state;
  // The creep is a sum of first-order lags that follow h, the output of the hysteresis. In one time step, the
  // output of lag j moves by share[j] of its distance from h.
  std::vector<double> share(rates_per_s.size());
  double step_s = 0.0, h = 0.0;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (!counts.empty() && !counts[i]) continue;
    if (state.empty()) {
      state = creep.settled(outputs[i]);
    } else {
      const double passed_s = time_s[i] - time_s[i - 1];
      if (!(std::abs(passed_s - step_s) <= as_long * passed_s)) {
        step_s = passed_s;
        for (std::size_t j = 0; j < share.size(); ++j) share[j] = -std::expm1(-rates_per_s[j] * step_s);
      }
      for (std::size_t j = 0; j < share.size(); ++j) state[j] += share[j] * (h - state[j]);
    }
    outputs[i] = h = creep.inverse(state, outputs[i]);
  }
  return outputs;
}

namespace {

// Maximum deviation of a row's time from the time of its cycle, as a share of a cycle. Such a deviation
// matters little: a late SYNC delays the sample and the drive together.
constexpr double unevenness = 0.1;

constexpr double two_pi = 2.0 * std::numbers::pi;
// Number of time constants after which a response has decayed to a millionth.
constexpr double decayed = 14.0;

// Returns the number of zeros to append to a signal. The Fourier transform is periodic: without the zeros,
// the end of the response would run into its beginning.
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

Grid grid_of(const std::vector<double>& time_s) {
  if (time_s.size() < 2) refuse(time_s.size(), " rows, expected at least 2");
  std::vector<double> steps_s(time_s.size() - 1);
  for (std::size_t n = 1; n < time_s.size(); ++n) steps_s[n - 1] = time_s[n] - time_s[n - 1];
  const double usual_s = median(steps_s);
  Grid grid{.cycles = {0}};
  for (const double step_s : steps_s)
    grid.cycles.push_back(grid.cycles.back() +
                          static_cast<Eigen::Index>(std::clamp(std::round(step_s / usual_s), 1.0, 1e9)));
  grid.cycle_s = (time_s.back() - time_s.front()) / static_cast<double>(grid.cycles.back());
  for (std::size_t n = 1; n < time_s.size(); ++n) {
    const double cycles = static_cast<double>(grid.cycles[n] - grid.cycles[n - 1]);
    if (!(std::abs(steps_s[n - 1] - cycles * grid.cycle_s) <= unevenness * grid.cycle_s))
      refuse("time_s of row ", n + 1, " is ", steps_s[n - 1],
             " s after the row before, expected the sampling interval of ", grid.cycle_s,
             " s, or a whole multiple of it if rows are missing, with a tolerance of 10 % of the interval");
  }
  if (grid.length() > 2 * static_cast<Eigen::Index>(time_s.size()))
    refuse(grid.length() - static_cast<Eigen::Index>(time_s.size()), " of ", grid.length(),
           " cycles have no row, expected rows for at least half of the cycles");
  return grid;
}

Eigen::VectorXd held_on(const Grid& grid, const std::vector<double>& column) {
  Eigen::VectorXd held(grid.length());
  for (std::size_t n = 0; n < column.size(); ++n) {
    const Eigen::Index end = n + 1 < column.size() ? grid.cycles[n + 1] : grid.length();
    held.segment(grid.cycles[n], end - grid.cycles[n]).setConstant(column[n]);
  }
  return held;
}

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

std::vector<std::vector<double>> quasi_static_outputs(const std::vector<Dataset>& datasets,
                                                      const Identified& identified) {
  const model::Hysteresis model(identified.parameters);
  const bool even = identified.parameters.symmetry == model::Symmetry::even;
  std::vector<std::vector<double>> outputs;
  for (std::size_t i = 0; i < datasets.size(); ++i)
    outputs.push_back(predict(model, even ? folded(datasets[i]) : datasets[i], {.creep = identified.creep},
                              identified.memories[i]));
  return outputs;
}

std::vector<Dataset> without_dynamics(std::vector<Dataset> datasets, const Identified& identified,
                                      const std::vector<std::vector<double>>& outputs) {
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    Dataset& dataset = datasets[i];
    const auto modelled = [&](const std::vector<double>& x, std::size_t row) {
      return identified.gains[i] * x[row] + identified.zero_at(i, dataset.time_s, row);
    };
    std::vector<double> change = respond(*identified.dynamics, dataset.time_s, outputs[i]);
    for (std::size_t row = 0; row < change.size(); ++row)
      change[row] = dataset.output[row] - modelled(change, row);
    change = before_dynamics(*identified.dynamics, dataset.time_s, change);
    for (std::size_t row = 0; row < change.size(); ++row)
      dataset.output[row] = modelled(outputs[i], row) + change[row];
  }
  return datasets;
}

std::vector<Dataset> without_dynamics(const std::vector<Dataset>& datasets, const Identified& identified) {
  return without_dynamics(datasets, identified, quasi_static_outputs(datasets, identified));
}

}  // namespace hystcan::identification
