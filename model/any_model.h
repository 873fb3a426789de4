// A model of any kind, chosen at run time: by a model file, by the twin's configuration.
//
// Parameters are values, copied and compared at will; a model is made of them once, which is where they are
// checked. Who computes with one visits the variant, outside the loop where that matters.
#pragma once

#include <string>
#include <variant>

#include "model/hysteresis.h"
#include "model/linear_mapping.h"
#include "model/prandtl_ishlinskii.h"
#include "model/preisach.h"

namespace hystcan::model {

/// Of a LinearMapping: the curves and the symmetry; k plays no part.
struct LinearMappingParameters {
  HysteresisParameters curves;
};

/// The average model is a recursive-memory one whose curves coincide (model/simplified.h).
using AnyParameters = std::variant<HysteresisParameters, LinearMappingParameters, PrandtlIshlinskiiParameters,
                                   PreisachParameters>;
using AnyModel = std::variant<Hysteresis, LinearMapping, PrandtlIshlinskii, Preisach>;

/// Throws std::invalid_argument where the model of that kind does.
AnyModel model_of(const AnyParameters& parameters);

const std::string& input_unit(const AnyParameters& parameters);
const std::string& output_unit(const AnyParameters& parameters);
/// Thresholds, input units.
const Interval& input_range(const AnyParameters& parameters);

}  // namespace hystcan::model
