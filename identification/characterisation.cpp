#include "identification/characterisation.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/text.h"
#include "identification/numerics/decompositions.h"
#include "identification/path.h"
#include "identification/regression.h"

namespace hystcan::identification {
namespace {

// Returns the interpolated output at `input` in one half cycle. Returns `nullopt` if the half cycle does not
// contain this input.
std::optional<double> output_at(const Dataset& dataset, const HalfCycle& half, double input) {
  const double way = half.to > half.from ? 1.0 : -1.0;
  const auto first = dataset.input.begin() + static_cast<std::ptrdiff_t>(half.begin);
  const auto last = dataset.input.begin() + static_cast<std::ptrdiff_t>(half.end);
  const auto beyond = std::find_if(first, last, [&](double v) { return way * (v - input) >= 0.0; });
  if (beyond == last || beyond == first) return std::nullopt;
  const auto i = static_cast<std::size_t>(beyond - dataset.input.begin());
  const double step = dataset.input[i] - dataset.input[i - 1];
  return dataset.output[i - 1] +
         (dataset.output[i] - dataset.output[i - 1]) * (input - dataset.input[i - 1]) / step;
}

// Returns the RMS difference between a half cycle and its repeat, over all repeats. Half cycle j is the
// repeat of half cycle j - 2 if both have the same ends, and if the half cycles j - 1 and j - 3 also have the
// same ends. Returns `nullopt` if there are too few repeats.
std::optional<double> repeatability_of(const Dataset& dataset, const std::vector<HalfCycle>& halves,
                                       double near) {
  double square = 0.0, count = 0.0;
  const auto have_same_ends = [&](const HalfCycle& a, const HalfCycle& b) {
    return std::abs(a.from - b.from) < near && std::abs(a.to - b.to) < near;
  };
  for (std::size_t j = 3; j + 1 < halves.size(); ++j) {
    const HalfCycle &now = halves[j], &before = halves[j - 2];
    if (!have_same_ends(now, before) || !have_same_ends(halves[j - 1], halves[j - 3])) continue;
    for (int i = 1; i < 20; ++i) {
      const double input = now.from + (now.to - now.from) * i / 20.0;
      const auto a = output_at(dataset, now, input), b = output_at(dataset, before, input);
      if (!a || !b) continue;
      square += (*a - *b) * (*a - *b);
      count += 1.0;
    }
  }
  if (count < 10.0) return std::nullopt;
  return std::sqrt(square / count);
}

double rate_spread_of(const Dataset& dataset, const std::vector<HalfCycle>& halves, double least) {
  std::vector<double> speeds;
  for (const HalfCycle& half : halves)
    if (std::abs(half.to - half.from) > least && half.end > half.begin + 1)
      speeds.push_back(std::abs(half.to - half.from) /
                       (dataset.time_s[half.end - 1] - dataset.time_s[half.begin]));
  if (speeds.size() < 2) return 1.0;
  const auto [slow, fast] = std::ranges::minmax_element(speeds);
  return *fast / *slow;
}

double slope_of(const std::vector<double>& x, const std::vector<double>& y) {
  const double count = static_cast<double>(x.size());
  const double mean_x = std::reduce(x.begin(), x.end()) / count,
               mean_y = std::reduce(y.begin(), y.end()) / count;
  double xy = 0.0, xx = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    xx += (x[i] - mean_x) * (x[i] - mean_x);
  }
  return xx > 0.0 ? xy / xx : 0.0;
}

// Returns the mean output of rising samples minus the mean output of falling samples at the same input. The
// result is negative if the output lags behind the input, as in a hysteresis.
double lead(const Dataset& dataset) {
  const model::Interval range = range_of(dataset.input);
  constexpr std::size_t bins = 40;
  struct Sums {
    double up = 0.0, ups = 0.0, down = 0.0, downs = 0.0;
  };
  std::vector<Sums> sums(bins);
  for (std::size_t i = 1; i < dataset.size(); ++i) {
    const double t = (dataset.input[i] - range.lo) / range.span();
    Sums& bin = sums[std::min(bins - 1, static_cast<std::size_t>(t * bins))];
    if (dataset.input[i] > dataset.input[i - 1]) {
      bin.up += dataset.output[i];
      bin.ups += 1.0;
    } else if (dataset.input[i] < dataset.input[i - 1]) {
      bin.down += dataset.output[i];
      bin.downs += 1.0;
    }
  }
  double lead = 0.0, count = 0.0;
  for (const Sums& bin : sums)
    if (bin.ups > 0.0 && bin.downs > 0.0) {
      lead += bin.up / bin.ups - bin.down / bin.downs;
      count += 1.0;
    }
  return count > 0.0 ? lead / count : 0.0;
}

}  // namespace

// Estimates the standard deviation s of the noise from the median of the magnitudes of the second
// differences. For white, normally distributed noise, a second difference has the standard deviation s
// sqrt(6), and this median is 0.6745 s sqrt(6).
double noise_of(const std::vector<double>& values) {
  std::vector<double> second_differences;
  for (std::size_t i = 2; i < values.size(); ++i)
    second_differences.push_back(std::abs(values[i] - 2.0 * values[i - 1] + values[i - 2]));
  return second_differences.empty() ? 0.0 : median(std::move(second_differences)) / 0.6745 / std::sqrt(6.0);
}

Characterisation characterise(const Dataset& dataset, model::Interval observed) {
  Characterisation found;
  found.samples = dataset.size();
  found.duration_s = dataset.time_s.back() - dataset.time_s.front();
  found.sample_time_s = found.duration_s / static_cast<double>(dataset.size() - 1);
  for (std::size_t i = 1; i < dataset.size(); ++i)
    if (std::abs(dataset.time_s[i] - dataset.time_s[i - 1] - found.sample_time_s) >
        0.01 * found.sample_time_s)
      found.uniform = false;
  const auto halves = half_cycles(dataset, 0.02 * observed.span());
  found.cycles = (halves.size() + 1) / 2;
  found.noise = noise_of(dataset.output);
  found.repeatability = repeatability_of(dataset, halves, 0.005 * observed.span());
  found.rate_spread = rate_spread_of(dataset, halves, 0.1 * observed.span());
  const Path path = trace(observed, model::Origin::lower_threshold, {}, dataset.input);
  std::size_t minor = 0;
  for (const Run& run : path.runs)
    if (path.branches[run.branch].parent != PathBranch::none) minor += run.end - run.begin;
  found.minor_fraction = static_cast<double>(minor) / static_cast<double>(dataset.size());
  return found;
}

Trends trends(const Dataset& dataset, const std::vector<double>& predicted) {
  Trends found;
  std::vector<double> residual = dataset.output;
  for (std::size_t i = 0; i < residual.size(); ++i) residual[i] -= predicted[i];
  found.gain = slope_of(predicted, residual) * span_of(predicted);
  const double duration = dataset.time_s.back() - dataset.time_s.front();
  found.drift = slope_of(dataset.time_s, residual) * duration;
  // Number of drifts that are computed for the standard error; each one leaves out another eighth of the
  // dataset.
  constexpr std::size_t blocks = 8;
  if (dataset.size() >= 10 * blocks) {
    std::vector<double> slopes;
    for (std::size_t b = 0; b < blocks; ++b) {
      std::vector<double> t, r;
      for (std::size_t i = 0; i < dataset.size(); ++i)
        if (i * blocks / dataset.size() != b) {
          t.push_back(dataset.time_s[i]);
          r.push_back(residual[i]);
        }
      slopes.push_back(slope_of(t, r) * duration);
    }
    const double mean = std::reduce(slopes.begin(), slopes.end()) / blocks;
    for (const double slope : slopes) found.drift_error += (slope - mean) * (slope - mean);
    // Standard error by the jackknife method.
    found.drift_error = std::sqrt(found.drift_error * (blocks - 1.0) / blocks);
  }
  std::vector<double> rate(dataset.size(), 0.0);
  for (std::size_t i = 1; i < dataset.size(); ++i)
    rate[i] = (dataset.input[i] - dataset.input[i - 1]) / (dataset.time_s[i] - dataset.time_s[i - 1]);
  found.rate = slope_of(rate, residual) * span_of(rate);
  return found;
}

model::Symmetry symmetry_of(const Dataset& dataset) {
  if (dataset.size() == 0) return model::Symmetry::none;
  const model::Interval range = range_of(dataset.input);
  if (!(range.lo < 0.0 && range.hi > 0.0) || std::abs(range.lo + range.hi) > 0.2 * range.span())
    return model::Symmetry::none;
  constexpr Eigen::Index order = 9;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(order + 1, order + 1);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(order + 1), T(order + 1);
  const double reach = std::max(-range.lo, range.hi);
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    chebyshev_row({-reach, reach}, dataset.input[i], T);
    H += T * T.transpose();
    g += T * dataset.output[i];
  }
  const Eigen::VectorXd c = shortest_solution(H, g, 1e-15);
  double even = 0.0, odd = 0.0;
  for (Eigen::Index i = 1; i <= order; ++i) (i % 2 == 0 ? even : odd) += c[i] * c[i];
  return odd < 0.01 * even ? model::Symmetry::even : model::Symmetry::none;
}

void check_limits(const Dataset& dataset) {
  for (const auto& [name, column] : {std::pair("time", &dataset.time_s), std::pair("input", &dataset.input),
                                     std::pair("output", &dataset.output)}) {
    for (std::size_t i = 0; i < column->size(); ++i)
      if (!(std::abs((*column)[i]) <= largest_value))
        refuse(name, " is ", (*column)[i], " in row ", i + 1, ", expected at most ", largest_value,
               " in magnitude");
    const double span = column->empty() ? 0.0 : range_of(*column).span();
    if (span != 0.0 && span < least_span)
      refuse("the ", name, " moves by ", span, ", expected at least ", least_span, ": check its unit");
  }
}

bool moves_one_way(const Dataset& dataset) {
  // Minimum swing of the input that counts as a reversal, as a share of its range.
  constexpr double least_turn = 0.02;
  if (dataset.size() < least_samples) return false;
  const double span = range_of(dataset.input).span();
  return span > 0.0 && turning_points(dataset, least_turn * span).empty();
}

void check_identifiable(const Dataset& dataset, model::Symmetry symmetry) {
  if (dataset.size() < least_samples) refuse(dataset.size(), " samples, expected at least ", least_samples);
  const Dataset seen = symmetry == model::Symmetry::even ? folded(dataset) : dataset;
  const model::Interval inputs = range_of(seen.input), outputs = range_of(seen.output);
  const auto constant = [](model::Interval range) {
    return range.span() <= 1e-12 * std::max(std::abs(range.lo), std::abs(range.hi));
  };
  if (constant(inputs)) refuse("the input is constant at ", inputs.lo, ", expected an input that moves");
  if (constant(outputs))
    refuse("the output is constant at ", outputs.lo, ", expected an output that follows the input");
  if (slope_of(seen.input, seen.output) < 0.0) throw OutputFalls();
  if (lead(seen) > 0.02 * outputs.span())
    refuse("the output leads the input: its loops run clockwise, ", rounded(lead(seen)),
           " wide on average; expected a lagging output: check that input and output are not interchanged");
}

}  // namespace hystcan::identification
