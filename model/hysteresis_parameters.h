// The parameters of a recursive memory-based model (model/hysteresis.h).
#pragma once

#include <optional>
#include <string>

#include "model/cubic_spline.h"
#include "model/fingerprint.h"
#include "model/memory.h"
#include "model/output_map.h"
#include "model/reference_curve.h"

namespace hystcan::model {

/// The identified numbers in a model file. `k_ascending` and `k_descending` are convergence rates in 1/input
/// unit; each may be negative.
struct HysteresisParameters {
  std::string input_unit;
  std::string output_unit;
  ReferenceCurve ascending;   ///< reference curve of the rising branches (f_0^A)
  ReferenceCurve descending;  ///< reference curve of the falling branches (f_0^D)
  double k_ascending = 0.0;
  double k_descending = 0.0;
  Symmetry symmetry = Symmetry::none;
  /// Maps the magnetisation or polarisation m of a butterfly to its output. With a map, `ascending` and
  /// `descending` are curves of m. `nullopt` for a model that is not a butterfly.
  std::optional<OutputMap> output_map{};
  /// The input map h, an increasing function of the input v. The distance between two inputs is the
  /// difference of their h(v), so that a branch converges at v with the rate k h'(v). `nullopt` means h(v) =
  /// v.
  std::optional<CubicSpline> input_map{};

  const Interval& input_range() const { return ascending.domain(); }
  const ReferenceCurve& curve(Direction direction) const {
    return direction == Direction::ascending ? ascending : descending;
  }
  double k(Direction direction) const {
    return direction == Direction::ascending ? k_ascending : k_descending;
  }
  /// Return the input map at the input v, h(v), and its derivative h'(v).
  double place(double v) const { return input_map ? input_map->value(v) : v; }
  double stretch(double v) const { return input_map ? input_map->slope(v) : 1.0; }
  /// Return the two ends of the major loop. L_0 (lower convergence point) is the point of the descending
  /// curve at the lower threshold; U_0 (upper threshold point) is the point of both curves at the upper
  /// threshold.
  Point lower_point() const { return {input_range().lo, descending.value(input_range().lo)}; }
  Point upper_point() const { return {input_range().hi, ascending.value(input_range().hi)}; }
  /// Returns the output of the model for a level. The level is the value of a branch: in a butterfly, the
  /// magnetisation or polarisation; in other models, the output itself.
  double output(double level) const { return output_map ? output_map->value(level) : level; }
  /// Returns the interval of outputs for the levels from `low` to `high`. In a butterfly, the output falls to
  /// a valley and then rises as the level increases. The levels before the valley are left out, because the
  /// inverse never uses them.
  Interval outputs(double low, double high) const {
    return output_map ? output_map->beyond_valley({low, high}) : Interval{low, high};
  }
  /// Returns the interval of outputs between the two ends of the major loop, lower_point() and upper_point().
  Interval output_range() const { return outputs(lower_point().level, upper_point().level); }
};

/// Adds all parameters except `k_ascending` and `k_descending` to the fingerprint.
void add_curves(Fingerprint& sum, const HysteresisParameters& parameters);

// The following functions return models without memory, for comparison with the full model. Their ascending
// and descending reference curves are equal, so that every branch follows this one curve.

/// Returns the paper's average model: the mean of the two reference curves, (f_0^A + f_0^D) / 2.
HysteresisParameters average(const HysteresisParameters& parameters);

/// Returns a model without hysteresis: a straight line with the same outputs at the two thresholds.
HysteresisParameters straight_line(const HysteresisParameters& parameters);

/// Returns a model without hysteresis: the straight line from (input.lo, output.lo) to (input.hi, output.hi).
/// It is used for an actuator if only its ranges are known.
HysteresisParameters straight_line(const std::string& input_unit, const std::string& output_unit,
                                   Interval input, Interval output);

}  // namespace hystcan::model
