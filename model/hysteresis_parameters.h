// The numbers of a recursive memory-based model (model/hysteresis.h): what its branches are made from.
#pragma once

#include <string>

#include "model/fingerprint.h"
#include "model/memory.h"
#include "model/reference_curve.h"

namespace hystcan::model {

/// What is identified and kept in a model file. k in 1/input unit, of either sign.
struct HysteresisParameters {
  std::string input_unit;
  std::string output_unit;
  ReferenceCurve ascending;   ///< f_0^A
  ReferenceCurve descending;  ///< f_0^D
  double k_ascending = 0.0;
  double k_descending = 0.0;
  Symmetry symmetry = Symmetry::none;
};

/// Adds all but the two k.
void add_curves(Fingerprint& sum, const HysteresisParameters& parameters);

}  // namespace hystcan::model
