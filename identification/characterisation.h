// Properties of a dataset that do not need a model: sampling, cycles, noise, repeatability, and reasons why
// no model can be identified from it.
#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <vector>

#include "identification/dataset.h"
#include "model/memory.h"
#include "model/reference_curve.h"

namespace hystcan::identification {

struct Characterisation {
  std::size_t samples = 0;
  double duration_s = 0.0;
  double sample_time_s = 0.0;  ///< mean sampling time
  bool uniform = true;         ///< every step is within 1 % of the mean
  std::size_t cycles = 0;
  double minor_fraction = 0.0;  ///< share of samples on branches that do not start at an end of the range
  double noise = 0.0;           ///< noise of one output sample, output units, from second differences
  /// RMS between a cycle and its repeat, output units; `nullopt`: no repeat.
  std::optional<double> repeatability;
  double rate_spread = 1.0;  ///< speed of the fastest half cycle / speed of the slowest one
};

/// Returns the standard deviation of white noise from sample to sample, from second differences; 0 if there
/// are fewer than 3 values.
double noise_of(const std::vector<double>& values);

/// `observed`: range of the inputs in the dataset. If symmetry is even, the inputs are folded.
Characterisation characterise(const Dataset& dataset, model::Interval observed);

/// Linear trends in the residual of a model (measured - predicted), output units.
struct Trends {
  double drift = 0.0;        ///< from the first sample to the last
  double drift_error = 0.0;  ///< standard error of the drift, from a block jackknife
  double rate = 0.0;         ///< between the fastest rise and the fastest fall
  double gain = 0.0;         ///< between the lowest and the highest prediction
};
Trends trends(const Dataset& dataset, const std::vector<double>& predicted);

/// Returns Symmetry::even if the output hardly changes with the sign of the input: x(v) = x(-v).
model::Symmetry symmetry_of(const Dataset& dataset);

/// Throws std::invalid_argument, with the row, if a value is outside the limits of dataset.h, or if a column
/// varies by less than least_span.
void check_limits(const Dataset& dataset);

/// Thrown if a sensor is reversed or mirrored.
struct OutputFalls : std::invalid_argument {
  OutputFalls()
      : std::invalid_argument(
            "the output falls when the input rises, expected it to rise: change the sign of the output") {}
};

/// True if the input only rises or only falls, so that the dataset has no loop. False for a dataset that
/// check_identifiable() rejects for its length or its constant input.
bool moves_one_way(const Dataset& dataset);

/// Throws std::invalid_argument if nothing can be identified: fewer than `least_samples`, a constant input or
/// output, an output that falls when the input rises, or loops that run clockwise.
void check_identifiable(const Dataset& dataset, model::Symmetry symmetry);
inline constexpr std::size_t least_samples = 20;

}  // namespace hystcan::identification
