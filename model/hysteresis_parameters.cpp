#include "model/hysteresis_parameters.h"

#include "base/words.h"

namespace hystcan::model {

void add_curves(Fingerprint& sum, const HysteresisParameters& parameters) {
  sum.add(parameters.input_unit);
  sum.add(parameters.output_unit);
  sum.add(word_of(parameters.symmetry));
  for (const ReferenceCurve* curve : {&parameters.ascending, &parameters.descending}) {
    sum.add(curve->domain().lo);
    sum.add(curve->domain().hi);
    sum.add(curve->coefficients());
    if (curve->basis() == Basis::spline) sum.add(curve->knots());
  }
  if (parameters.input_map) {
    sum.add(parameters.input_map->knots());
    sum.add(parameters.input_map->coefficients());
  }
  if (!parameters.output_map) return;
  sum.add(parameters.output_map->inner().lo);
  sum.add(parameters.output_map->inner().hi);
  sum.add(parameters.output_map->coefficients());
}

}  // namespace hystcan::model
