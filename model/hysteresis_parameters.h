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

/// The identified numbers of a model file. k is in 1/input unit and has either sign.
struct HysteresisParameters {
  std::string input_unit;
  std::string output_unit;
  ReferenceCurve ascending;   ///< f_0^A
  ReferenceCurve descending;  ///< f_0^D
  double k_ascending = 0.0;
  double k_descending = 0.0;
  Symmetry symmetry = Symmetry::none;
  /// Only for a butterfly: maps the magnetisation or polarisation m to the output. `ascending` and
  /// `descending` are then curves of m.
  std::optional<OutputMap> output_map{};
  /// h: a branch converges with the distance |h(v) - h(v_s)|, so that the rate at v is k h'(v). `nullopt`
  /// means h(v) = v.
  std::optional<CubicSpline> input_map{};

  const Interval& input_range() const { return ascending.domain(); }
  const ReferenceCurve& curve(Direction direction) const {
    return direction == Direction::ascending ? ascending : descending;
  }
  double k(Direction direction) const {
    return direction == Direction::ascending ? k_ascending : k_descending;
  }
  /// Return h(v), and its derivative h'(v).
  double place(double v) const { return input_map ? input_map->value(v) : v; }
  double stretch(double v) const { return input_map ? input_map->slope(v) : 1.0; }
  /// Return the lower convergence point L_0 and the upper threshold point U_0.
  Point lower_point() const { return {input_range().lo, descending.value(input_range().lo)}; }
  Point upper_point() const { return {input_range().hi, ascending.value(input_range().hi)}; }
  /// Returns the output for this level of a branch.
  double output(double level) const { return output_map ? output_map->value(level) : level; }
  /// Returns the outputs from output(low) to output(high), without the part before a butterfly's valley.
  Interval outputs(double low, double high) const {
    return output_map ? output_map->beyond_valley({low, high}) : Interval{low, high};
  }
  /// Returns the outputs from the lower convergence point to the upper threshold point.
  Interval output_range() const { return outputs(lower_point().level, upper_point().level); }
};

/// Adds all parameters except `k_ascending` and `k_descending` to the fingerprint.
void add_curves(Fingerprint& sum, const HysteresisParameters& parameters);

// Models without memory, for comparison with the full model. In each of them the ascending and the descending
// reference curve are the same curve. Every branch follows this curve, so that no memory is needed.

/// Returns the paper's average model: the mean of the two reference curves, (f_0^A + f_0^D) / 2.
HysteresisParameters average(const HysteresisParameters& parameters);

/// Returns the straight line from the lower convergence point to the upper threshold point.
HysteresisParameters straight_line(const HysteresisParameters& parameters);

/// Returns the straight line from (input.lo, output.lo) to (input.hi, output.hi), for an actuator of which
/// only the ranges are known.
HysteresisParameters straight_line(const std::string& input_unit, const std::string& output_unit,
                                   Interval input, Interval output);

}  // namespace hystcan::model
