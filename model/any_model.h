// A model of any kind, chosen at run time: by a model file, by the twin's configuration.
//
// Parameters are plain values that can be copied and compared. A model is constructed from them once; the
// constructor checks them. Code that computes with a model visits the variant outside time-critical loops.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "model/hysteresis.h"
#include "model/linear_mapping.h"
#include "model/prandtl_ishlinskii.h"
#include "model/preisach.h"

namespace hystcan::model {

/// Parameters of a LinearMapping: the curves and the symmetry. k is not used.
struct LinearMappingParameters : HysteresisParameters {};

/// The average model is a recursive-memory model whose two curves coincide.
using AnyParameters = std::variant<HysteresisParameters, LinearMappingParameters, PrandtlIshlinskiiParameters,
                                   PreisachParameters>;
using AnyModel = std::variant<Hysteresis, LinearMapping, PrandtlIshlinskii, Preisach>;

/// Throws std::invalid_argument if the constructor of the model does.
AnyModel model_of(const AnyParameters& parameters);

const std::string& input_unit(const AnyParameters& parameters);
const std::string& output_unit(const AnyParameters& parameters);
/// Thresholds, input units.
const Interval& input_range(const AnyParameters& parameters);

/// The length of nm, um (also with a Greek mu), mm and m in um; none for other units.
std::optional<double> length_um(std::string_view unit);

/// The same model with its output in um, as the position of an axis is. A model whose output is not a length
/// is returned as it is.
AnyParameters in_um(AnyParameters parameters);

}  // namespace hystcan::model
