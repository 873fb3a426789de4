// A hysteresis model of any kind. A model file or the configuration of the twin selects the kind at run time.
//
// The parameters of a model are plain values that can be copied and compared. The constructor of a model
// checks its parameters once. Time-critical code does not use the variant: std::visit is called before the
// loop.
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

/// Parameters of the model LinearMapping: the two reference curves and the symmetry. The inherited members
/// `k_ascending` and `k_descending` are ignored.
struct LinearMappingParameters : HysteresisParameters {};

/// The parameters of every kind of model. The average model, which has no hysteresis (average() in
/// model/hysteresis_parameters.h), has no type of its own: it is a HysteresisParameters whose two reference
/// curves are equal.
using AnyParameters = std::variant<HysteresisParameters, LinearMappingParameters, PrandtlIshlinskiiParameters,
                                   PreisachParameters>;
using AnyModel = std::variant<Hysteresis, LinearMapping, PrandtlIshlinskii, Preisach>;

/// Constructs the model of these parameters. Throws std::invalid_argument if they are not valid.
AnyModel model_of(const AnyParameters& parameters);

const std::string& input_unit(const AnyParameters& parameters);
const std::string& output_unit(const AnyParameters& parameters);
/// Returns the range of the input between the two thresholds, in input units.
const Interval& input_range(const AnyParameters& parameters);

/// Returns how many um one `unit` is. Known units are nm, um (also with a Greek mu), mm and m; returns
/// `nullopt` for others.
std::optional<double> length_um(std::string_view unit);

/// Returns the same model with its output in um, the unit of an axis position. If the output unit is not a
/// length, returns the model unchanged.
AnyParameters in_um(AnyParameters parameters);

}  // namespace hystcan::model
