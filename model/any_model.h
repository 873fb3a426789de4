// A model of any kind, chosen at run time: by a model file, by the twin's configuration.
//
// Parameters are plain values that can be copied and compared. A model is constructed from them once; the
// constructor checks them. Code that computes with a model visits the variant outside time-critical loops.
#pragma once

#include <string>
#include <variant>

#include "model/hysteresis.h"
#include "model/linear_mapping.h"
#include "model/prandtl_ishlinskii.h"
#include "model/preisach.h"

namespace hystcan::model {

/// Parameters of a LinearMapping: the curves and the symmetry. k is not used.
struct LinearMappingParameters {
  HysteresisParameters curves;
};

/// The average model is a recursive-memory model whose two curves coincide (model/simplified.h).
using AnyParameters = std::variant<HysteresisParameters, LinearMappingParameters, PrandtlIshlinskiiParameters,
                                   PreisachParameters>;
using AnyModel = std::variant<Hysteresis, LinearMapping, PrandtlIshlinskii, Preisach>;

/// Throws std::invalid_argument if the constructor of the model does.
AnyModel model_of(const AnyParameters& parameters);

const std::string& input_unit(const AnyParameters& parameters);
const std::string& output_unit(const AnyParameters& parameters);
/// Thresholds, input units.
const Interval& input_range(const AnyParameters& parameters);

}  // namespace hystcan::model
