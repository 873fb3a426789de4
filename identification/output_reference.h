// The outputs of an absolute sensor: a small stroke far from zero. Squares of such outputs leave no digits
// for the stroke, so that a reference output is taken away before they are summed up.
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::identification {

/// The middle of the outputs of each dataset; 0 if it lies within ten times their span, where squares have
/// enough digits, and if the output is constant. `one_zero`: the same for all, that of the first dataset.
std::vector<double> reference_outputs(const std::vector<Dataset>& datasets, bool one_zero);

/// Adds `sign` times its reference to each output of a dataset.
void move_outputs(std::vector<Dataset>& datasets, const std::vector<double>& references, double sign = 1.0);

/// The model, and the zeros, for datasets of which each output is larger by `sign` times the reference of its
/// dataset: x + r_0, and y_i = g_i (x + r_0) + zero_i + r_i - g_i r_0.
void move_outputs(Identified& identified, const std::vector<double>& references, double sign = 1.0);

}  // namespace hystcan::identification
