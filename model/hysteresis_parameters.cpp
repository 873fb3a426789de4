#include "model/hysteresis_parameters.h"

namespace hystcan::model {

void add_curves(Fingerprint& sum, const HysteresisParameters& parameters) {
  sum.add(parameters.input_unit);
  sum.add(parameters.output_unit);
  sum.add(parameters.symmetry == Symmetry::even ? "even" : "none");
  for (const ReferenceCurve* curve : {&parameters.ascending, &parameters.descending}) {
    sum.add(curve->domain().lo);
    sum.add(curve->domain().hi);
    sum.add(curve->chebyshev_coefficients());
  }
}

}  // namespace hystcan::model
