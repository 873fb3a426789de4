// Properties of a dataset that do not need a model: sampling, cycles, noise and repeatability. Also checks if
// a model can be identified from the dataset.
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
  double sample_time_s = 0.0;  ///< mean time between two samples
  bool uniform = true;         ///< true if every time step is within 1 % of the mean
  std::size_t cycles = 0;
  /// Share of samples on inner loops: on branches that do not start at an end of the range.
  double minor_fraction = 0.0;
  double noise = 0.0;  ///< noise of a single output sample, output units; see noise_of()
  /// RMS difference between a cycle and its repeat, output units; `nullopt` if no cycle is repeated.
  std::optional<double> repeatability;
  double rate_spread = 1.0;  ///< speed of the fastest half cycle, divided by the speed of the slowest one
};

/// Returns the standard deviation of the white noise in a series of values, computed from second differences.
/// Returns 0 if there are fewer than 3 values.
double noise_of(const std::vector<double>& values);

/// Computes the properties of a dataset. `observed` is the range of the inputs. If symmetry is even, the
/// caller must first replace each input by its magnitude (folded()).
Characterisation characterise(const Dataset& dataset, model::Interval observed);

/// Linear trends in the residual of a model (measured output minus predicted output). Each trend is a change
/// of the residual, in output units.
struct Trends {
  double drift = 0.0;        ///< change of the residual from the first sample to the last one
  double drift_error = 0.0;  ///< standard error of `drift`, by the jackknife method with blocks
  /// Error that depends on the speed of the input: a line is fitted to the residual over the speed. This is
  /// the rise of the line from the fastest falling input to the fastest rising input, in output units.
  double rate = 0.0;
  /// Error of the gain: a line is fitted to the residual over the predicted output. This is the rise of the
  /// line from the lowest prediction to the highest one, in output units.
  double gain = 0.0;
};
Trends trends(const Dataset& dataset, const std::vector<double>& predicted);

/// Returns Symmetry::even if the output is nearly the same for an input and for its negative, x(v) = x(-v).
/// Otherwise returns Symmetry::none.
model::Symmetry symmetry_of(const Dataset& dataset);

/// Throws std::invalid_argument if a value is outside the limits of dataset.h; the message contains the row.
/// Also throws if a column that is not constant varies by less than least_span.
void check_limits(const Dataset& dataset);

/// Thrown if the output falls when the input rises: the sensor is reversed or mirrored.
struct OutputFalls : std::invalid_argument {
  OutputFalls()
      : std::invalid_argument(
            "the output falls when the input rises, expected a rising output: change the sign of the "
            "output") {}
};

/// Returns true if the input never reverses, so that the dataset has no loop. Returns false for a dataset
/// that check_identifiable() refuses because it is too short or has a constant input.
bool moves_one_way(const Dataset& dataset);

/// Throws std::invalid_argument if no model can be identified from the dataset. Reasons are fewer than
/// `least_samples` samples, a constant input, a constant output, an output that falls when the input rises,
/// or loops that run clockwise.
void check_identifiable(const Dataset& dataset, model::Symmetry symmetry);
inline constexpr std::size_t least_samples = 20;

}  // namespace hystcan::identification
