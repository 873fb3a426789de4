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
/// With the reference r_i and the gain g_i of dataset i, and the first dataset as i = 0, the new values are
///
///   output of the model     x + sign r_0
///   offset of dataset i     offset_i + sign (r_i - g_i r_0)
///
/// The prediction g_i x + offset_i of dataset i therefore moves by sign r_i.
void move_outputs(Identified& identified, const std::vector<double>& references, double sign = 1.0);

}  // namespace hystcan::identification
