// Identifies a model with the help of an old model of the same actuator, for datasets that do not determine
// all parameters.
//
// The loops of the old model are added as one more dataset with its own offset. It has n_old samples with a
// small weight w; the measured datasets have n samples:
//
//   minimise  sum (x - y)^2 + w^2 sum (x - y_old)^2,     w^2 n_old = share * n
//
//   x          output of the new model
//   y, y_old   measured output, output of the old model
//   share      weight of all old samples together, relative to the weight of the measured samples
//
// Where the inputs of the datasets excite the model, the datasets decide; elsewhere, the old model decides.
// The loops of the old model are the major loop, and first-order reversal curves from both of its branches.
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

/// Identifies a model from the datasets and the old model.
///
///   - The symmetry is that of the old model.
///   - The shape of the curves is that of the old model, unless the options contain a shape.
///   - The creep is that of the old model, unless the options contain a creep.
///   - If the search finds no delay, the model gets the old delay, unless the old delay raises the error.
///
/// Datasets, errors and held-out cycles in the result refer to `datasets` only. Throws std::invalid_argument
/// like identify(), and also if the old model is a butterfly with an output map.
Identified identify_from(const OldModel& old, const std::vector<Dataset>& datasets, IdentifyOptions options);

}  // namespace hystcan::identification
