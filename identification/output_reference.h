// The outputs of an absolute sensor: a small stroke far from zero. Squares of such outputs have no digits
// left for the stroke, so a reference output is subtracted before they are summed.
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::identification {

/// Returns the middle of the outputs of each dataset; 0 if it is within ten times their span, where squares
/// have enough digits, or if the output is constant. `one_zero`: every dataset has the middle of the first
/// dataset.
std::vector<double> reference_outputs(const std::vector<Dataset>& datasets, bool one_zero);

/// Adds to each output `sign` times the reference of its dataset.
void move_outputs(std::vector<Dataset>& datasets, const std::vector<double>& references, double sign = 1.0);

/// Changes the model and the zeros as if each output were larger by `sign` times the reference of its
/// dataset: x + r_0, and y_i = g_i (x + r_0) + zero_i + r_i - g_i r_0.
void move_outputs(Identified& identified, const std::vector<double>& references, double sign = 1.0);

}  // namespace hystcan::identification
