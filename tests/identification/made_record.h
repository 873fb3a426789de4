// Datasets computed with a known model, for tests of the identification.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "identification/dataset.h"
#include "model/hysteresis.h"

namespace hystcan::identification {

/// Inputs along straight lines from point to point, in steps of at most `step`. Every point is met exactly.
inline std::vector<double> travelled(const std::vector<double>& points, double step) {
  std::vector<double> inputs{points.front()};
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double from = points[i - 1], way = points[i] - from;
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(way) / step)));
    for (int j = 1; j < steps; ++j) inputs.push_back(from + way * j / steps);
    inputs.push_back(points[i]);
  }
  return inputs;
}

/// Two major loops, six nested loops and six first-order reversal curves, as fractions of the range. They
/// start at the lower threshold.
inline std::vector<double> loops_and_reversal_curves() {
  std::vector<double> points{0.0, 1.0, 0.0, 1.0, 0.0, 0.95, 0.1, 0.85, 0.2, 0.75, 0.3, 0.65, 0.4, 0.55, 1.0};
  for (const double reversal : {0.85, 0.7, 0.55, 0.4, 0.25, 0.1}) {
    points.push_back(reversal);
    points.push_back(1.0);
  }
  points.push_back(0.0);
  return points;
}

inline std::vector<double> in_range(std::vector<double> parts, model::Interval range) {
  for (double& part : parts) part = range.lo + part * range.span();
  return parts;
}

/// The response of `truth` from `state`, sampled at 1 kHz.
template <class Model>
Dataset record_of(const Model& truth, typename Model::State state, std::vector<double> inputs) {
  Dataset dataset{"V", "um", {}, std::move(inputs), {}};
  for (std::size_t i = 0; i < dataset.input.size(); ++i) {
    dataset.time_s.push_back(1e-3 * static_cast<double>(i));
    dataset.output.push_back(truth.advance(state, dataset.input[i]).value);
  }
  return dataset;
}

/// The response to loops_and_reversal_curves() from the lower threshold, with `steps` steps per range.
template <class Model>
Dataset record_of(const Model& truth, double steps) {
  const model::Interval range = truth.input_range();
  return record_of(truth, truth.at_lower_threshold(),
                   travelled(in_range(loops_and_reversal_curves(), range), range.span() / steps));
}

/// Adds white noise of standard deviation `deviation`, output units.
inline Dataset with_noise(Dataset dataset, double deviation, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, deviation);
  for (double& x : dataset.output) x += noise(random);
  return dataset;
}

}  // namespace hystcan::identification
