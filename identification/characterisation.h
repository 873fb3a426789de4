// What a dataset is, before any model: sampling, cycles, noise, repeatability, and what speaks against
// identifying anything from it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "identification/dataset.h"
#include "model/memory.h"
#include "model/reference_curve.h"

namespace hystcan::identification {

struct Characterisation {
  std::size_t samples = 0;
  double duration_s = 0.0;
  double sample_time_s = 0.0;  ///< mean
  bool uniform = true;         ///< every step within 1 % of the mean
  std::size_t cycles = 0;
  double minor_fraction = 0.0;  ///< of the samples: on branches that do not come from an end of the range
  double noise = 0.0;           ///< of a single output sample, output units, from its second differences
  std::optional<double> repeatability;  ///< RMS between a cycle and its repeat, output units; none: no repeat
  double rate_spread = 1.0;             ///< fast cycles' speed over slow ones'
};

/// `observed`: inputs that occur. Inputs folded where symmetry is even.
Characterisation characterise(const Dataset& dataset, model::Interval observed);

/// Linear trends in what a model leaves unexplained, output units.
struct Trends {
  double drift = 0.0;        ///< from the first sample to the last
  double drift_error = 0.0;  ///< its standard error, by blocks
  double rate = 0.0;         ///< between the fastest rise and the fastest fall
};
Trends trends(const Dataset& dataset, const std::vector<double>& residual);

/// Even where the output hardly changes with the input's sign: x(v) = x(-v).
model::Symmetry symmetry_of(const Dataset& dataset);

/// Throws std::invalid_argument where nothing can be identified: fewer than `least_samples`, an input or
/// output that is constant, an output that falls where the input rises, loops that run clockwise.
void refuse_hopeless(const Dataset& dataset, model::Symmetry symmetry);
inline constexpr std::size_t least_samples = 20;

}  // namespace hystcan::identification
