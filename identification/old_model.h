// Identification that starts from an old model, for datasets that do not determine all parameters.
//
// The loops of the old model are added as one more dataset, with a zero of its own and a small weight w for
// its n_old samples:
//
//   minimise  sum (x - y)^2 + w^2 sum (x - y_old)^2,     w^2 n_old = share * n
//
// Thus the datasets decide wherever their inputs excite the model, and the old model decides elsewhere. Its
// loops are the major loop, and first-order reversal curves from both branches.
#pragma once

#include <optional>
#include <vector>

#include "identification/identify.h"
#include "model/hysteresis_parameters.h"
#include "model/output_creep.h"

namespace hystcan::identification {

struct OldModel {
  model::HysteresisParameters parameters;
  double delay_s = 0.0;
  std::optional<model::OutputCreep::Config> creep{};
};

/// Keeps the symmetry of the old model, and the shape of its curves unless the options set a shape. Keeps the
/// old delay if the datasets do not need a delay and the old one does not raise the error. The creep is the
/// creep of the old model, or the one in the options. Datasets, errors and held-out cycles in the result
/// refer to `datasets` only. Throws std::invalid_argument like identify(), and if the old model is a
/// butterfly with an output map.
Identified identify_from(const OldModel& old, const std::vector<Dataset>& datasets, IdentifyOptions options);

}  // namespace hystcan::identification
