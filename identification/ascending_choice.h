// Selects the ascending reference curve of a model if no sample is on this curve.
//
// No sample is on it if every dataset begins with a memory that comes from a threshold. Then all branches
// follow from one branch f_1^A, which starts at the lower threshold v_lo with the output L_0 of the
// descending curve:
//
//   f_1^A(v) = f_0^A(v) + (L_0 - f_0^A(v_lo)) g(h_hi - h(v); h_hi - h_lo, k_A)         model/hysteresis.h
//
//   f_0^A, k_A   ascending reference curve and its convergence rate
//   g            convergence from 1 to 0
//   h            input map; h_lo and h_hi are its values at the thresholds
//
// The curve f_0^A + c g gives the same f_1^A for every number c. The samples therefore do not determine c,
// and a fit extrapolates without any basis. f_1^A itself is one of these curves: it begins at L_0 and follows
// the samples. It is selected.
#pragma once

#include "model/hysteresis_parameters.h"

namespace hystcan::identification {

/// Returns the model with a new ascending reference curve: the branch that rises from the point of the
/// descending curve at the lower threshold. The new curve is a polynomial of the lowest sufficient order, or
/// a spline with the same knots, that differs from the branch by at most `tolerance` (output units). Returns
/// the model unchanged if no such curve exists, or if the new model is not valid.
model::HysteresisParameters with_ascending_from_lower(const model::HysteresisParameters& parameters,
                                                      double tolerance);

/// Returns true if the two reference curves meet at the lower threshold, as they do after
/// with_ascending_from_lower().
bool begins_at_lower_point(const model::HysteresisParameters& parameters);

}  // namespace hystcan::identification
