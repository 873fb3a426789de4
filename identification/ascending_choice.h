// The ascending reference curve where no sample shows it.
//
// Where every input comes from a threshold, all branches follow from the one that leaves L_0:
//
//   f_1^A(v) = f_0^A(v) + (L_0 - f_0^A(v_lo)) g(h_hi - h(v); h_hi - h_lo, k_A)         model/hysteresis.h
//
// f_0^A + c g gives the same f_1^A for every c, so the samples do not determine c, and what a fit
// extrapolates there is worth nothing. f_1^A itself is one of these curves. It begins at L_0 and goes where
// the samples go.
#pragma once

#include "model/hysteresis_parameters.h"

namespace hystcan::identification {

/// The model with f_1^A as its ascending curve, which is a polynomial or spline near it: at most `tolerance`
/// away (output units), with the lowest order that is enough. Without one, or where the model would not be
/// valid, the model itself.
model::HysteresisParameters with_ascending_from_lower(const model::HysteresisParameters& parameters,
                                                      double tolerance);

/// True: the ascending curve begins at L_0.
bool begins_at_lower_point(const model::HysteresisParameters& parameters);

}  // namespace hystcan::identification
