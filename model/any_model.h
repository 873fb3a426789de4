// A model of any kind, selected at run time by a model file or by the twin's configuration.
//
// Parameters are plain values that can be copied and compared. The constructor of a model checks them once.
// Code that computes with a model visits the variant outside time-critical loops.
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

/// Parameters of a LinearMapping: the curves and the symmetry. `k_ascending` and `k_descending` are ignored.
struct LinearMappingParameters : HysteresisParameters {};

/// The average model is a HysteresisParameters whose two curves coincide.
using AnyParameters = std::variant<HysteresisParameters, LinearMappingParameters, PrandtlIshlinskiiParameters,
                                   PreisachParameters>;
using AnyModel = std::variant<Hysteresis, LinearMapping, PrandtlIshlinskii, Preisach>;

/// Constructs the model. Throws std::invalid_argument if the parameters are not valid.
AnyModel model_of(const AnyParameters& parameters);

const std::string& input_unit(const AnyParameters& parameters);
const std::string& output_unit(const AnyParameters& parameters);
/// Input range between the two thresholds, in input units.
const Interval& input_range(const AnyParameters& parameters);

/// Length of one unit in um for nm, um (also with a Greek mu), mm and m; `nullopt` for other units.
std::optional<double> length_um(std::string_view unit);

/// Returns the same model with its output converted to um, the unit of an axis position. Returns the model
/// unchanged if its output is not a length.
AnyParameters in_um(AnyParameters parameters);

}  // namespace hystcan::model
