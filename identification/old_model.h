// Identification that starts from an old model, for datasets that do not determine everything.
//
// The loops of the old model join as one more dataset, with a zero of its own and a small weight w for its
// n_old samples:
//
//   minimise  sum (x - y)^2 + w^2 sum (x - y_old)^2,     w^2 n_old = share * n
//
// So the datasets decide wherever their inputs excite the model, and the old model elsewhere. Its loops are
// the major loop, and first-order reversal curves from both branches.
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

/// The symmetry is that of the old model, and so is the shape of the curves where the options leave it open.
/// Where the datasets do not need a delay, it is the old one, unless this raises the error. The creep is the
/// old one, or that of the options. What the result says of datasets, errors and held-out cycles is of
/// `datasets` alone. Throws std::invalid_argument like identify(), and where the old model is a butterfly
/// with an output map.
Identified identify_from(const OldModel& old, const std::vector<Dataset>& datasets, IdentifyOptions options);

}  // namespace hystcan::identification
