// Moves outputs that are far from zero, such as the outputs of an absolute sensor that measures a small
// stroke. The squares of large outputs have no digits left for the stroke. Therefore a reference output is
// subtracted before a fit, and added afterwards.
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::identification {

/// Returns the reference output of each dataset: the middle of its outputs. The reference is 0 if the
/// magnitude of the middle is at most ten times the span of the outputs, because the squares of such outputs
/// have enough digits. It is also 0 if the output is constant. `one_zero`: every dataset gets the reference
/// of the first dataset.
std::vector<double> reference_outputs(const std::vector<Dataset>& datasets, bool one_zero);

/// Adds `sign` times the reference of its dataset to each output.
void move_outputs(std::vector<Dataset>& datasets, const std::vector<double>& references, double sign = 1.0);

/// Changes an identified model as if `sign` times the reference of its dataset had been added to each output.
/// The output x of the model moves by the reference r_0 of the first dataset. The offset of dataset i, which
/// has the gain g_i, changes so that its output y_i moves by its own reference r_i:
///
///   x + r_0,   y_i = g_i (x + r_0) + offset_i + r_i - g_i r_0
void move_outputs(Identified& identified, const std::vector<double>& references, double sign = 1.0);

}  // namespace hystcan::identification
