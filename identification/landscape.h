// The error over both k.
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "identification/identify.h"

namespace hystcan::identification {

/// RMS of the best curves for each pair of k, output units. All other values are as identified.
struct Landscape {
  std::vector<double> k_ascending, k_descending;
  std::vector<std::vector<double>> rms;  ///< [descending][ascending]
};
Landscape landscape(const std::vector<Dataset>& datasets, const Identified& identified, int points);

}  // namespace hystcan::identification
