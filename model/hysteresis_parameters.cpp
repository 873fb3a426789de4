#include "model/hysteresis_parameters.h"

#include <algorithm>

#include "base/words.h"

namespace hystcan::model {

void add_curves(Fingerprint& sum, const HysteresisParameters& parameters) {
  sum.add(parameters.input_unit, parameters.output_unit, word_of(parameters.symmetry));
  for (const ReferenceCurve* curve : {&parameters.ascending, &parameters.descending}) {
    sum.add(curve->domain().lo, curve->domain().hi, curve->coefficients());
    if (curve->basis() == Basis::spline) sum.add(curve->knots());
  }
  if (const auto& map = parameters.input_map) sum.add(map->knots(), map->coefficients());
  if (const auto& map = parameters.output_map) sum.add(map->inner().lo, map->inner().hi, map->coefficients());
}

namespace {

HysteresisParameters on_one_curve(const HysteresisParameters& parameters, const ReferenceCurve& curve) {
  HysteresisParameters result = parameters;
  result.ascending = curve;
  result.descending = curve;
  result.k_ascending = 0.0;
  result.k_descending = 0.0;
  return result;
}

ReferenceCurve line(Interval input, Interval output) {
  return {Basis::chebyshev, {0.5 * (output.lo + output.hi), 0.5 * output.span()}, input};
}

}  // namespace

HysteresisParameters average(const HysteresisParameters& parameters) {
  const auto& ascending = parameters.ascending.coefficients();
  const auto& descending = parameters.descending.coefficients();
  std::vector<double> mean(std::max(ascending.size(), descending.size()));
  for (std::size_t i = 0; i < ascending.size(); ++i) mean[i] += 0.5 * ascending[i];
  for (std::size_t i = 0; i < descending.size(); ++i) mean[i] += 0.5 * descending[i];
  return on_one_curve(parameters, parameters.ascending.with(mean));
}

HysteresisParameters straight_line(const HysteresisParameters& parameters) {
  return on_one_curve(parameters, line(parameters.input_range(),
                                       {parameters.lower_point().level, parameters.upper_point().level}));
}

HysteresisParameters straight_line(const std::string& input_unit, const std::string& output_unit,
                                   Interval input, Interval output) {
  HysteresisParameters parameters;
  parameters.input_unit = input_unit;
  parameters.output_unit = output_unit;
  return on_one_curve(parameters, line(input, output));
}

}  // namespace hystcan::model
