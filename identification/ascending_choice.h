// Selects the ascending reference curve if no sample shows it.
//
// If every dataset begins with a memory that comes from a threshold, all branches follow from the branch that
// rises from the lower convergence point L_0:
//
//   f_1^A(v) = f_0^A(v) + (L_0 - f_0^A(v_lo)) g(h_hi - h(v); h_hi - h_lo, k_A)         model/hysteresis.h
//
// f_0^A + c g gives the same f_1^A for every c, so the samples do not determine c, and the extrapolation of a
// fit there is worthless. f_1^A itself is one of these curves: it begins at L_0 and follows the samples.
#pragma once

#include "model/hysteresis_parameters.h"

namespace hystcan::identification {

/// Returns the model with f_1^A as its ascending curve, approximated by a polynomial or spline of the lowest
/// order that is within `tolerance` (output units). Returns the model unchanged if there is none, or if the
/// new model would not be valid.
model::HysteresisParameters with_ascending_from_lower(const model::HysteresisParameters& parameters,
                                                      double tolerance);

/// True if the ascending curve begins at the lower convergence point L_0.
bool begins_at_lower_point(const model::HysteresisParameters& parameters);

}  // namespace hystcan::identification
