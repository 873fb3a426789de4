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

/// The identified numbers that a model file contains. k is in 1/input unit, of either sign.
struct HysteresisParameters {
  std::string input_unit;
  std::string output_unit;
  ReferenceCurve ascending;   ///< f_0^A
  ReferenceCurve descending;  ///< f_0^D
  double k_ascending = 0.0;
  double k_descending = 0.0;
  Symmetry symmetry = Symmetry::none;
  std::optional<OutputMap> output_map{};  ///< of a butterfly; the curves are then those of m
  /// h: a branch converges with the distance |h(v) - h(v_s)|, so that the rate at v is k h'(v).
  /// None: h(v) = v.
  std::optional<CubicSpline> input_map{};

  const Interval& input_range() const { return ascending.domain(); }
  const ReferenceCurve& curve(Direction direction) const {
    return direction == Direction::ascending ? ascending : descending;
  }
  double k(Direction direction) const {
    return direction == Direction::ascending ? k_ascending : k_descending;
  }
  double place(double v) const { return input_map ? input_map->value(v) : v; }                  ///< h
  double stretch(double v) const { return input_map ? input_map->slope(v) : 1.0; }              ///< h'
  Point lower_point() const { return {input_range().lo, descending.value(input_range().lo)}; }  ///< L_0
  Point upper_point() const { return {input_range().hi, ascending.value(input_range().hi)}; }   ///< U_0
  /// Output where a curve has this value.
  double output(double level) const { return output_map ? output_map->value(level) : level; }
  /// Outputs from the one of `low` to the one of `high`, without what lies before a butterfly's valley.
  Interval outputs(double low, double high) const {
    return output_map ? output_map->beyond_valley({low, high}) : Interval{low, high};
  }
  /// From L_0 to U_0.
  Interval output_range() const { return outputs(lower_point().level, upper_point().level); }
};

/// Adds all parameters except the two k.
void add_curves(Fingerprint& sum, const HysteresisParameters& parameters);

/// Models without memory, most of them made from the reference curves. The full model is compared with them.
///
/// All are hysteresis models whose ascending and descending reference curves coincide. Every branch lies on
/// this curve, so that no memory is needed.
///
/// The paper's average model: the mean of the two reference curves, (f_0^A + f_0^D) / 2.
HysteresisParameters average(const HysteresisParameters& parameters);

/// The straight line from the lower convergence point to the upper threshold point.
HysteresisParameters straight_line(const HysteresisParameters& parameters);

/// The straight line from the lowest output at the lowest input to the highest at the highest, where nothing
/// else is known.
HysteresisParameters straight_line(const std::string& input_unit, const std::string& output_unit,
                                   Interval input, Interval output);

}  // namespace hystcan::model
