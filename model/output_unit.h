// The output of an axis is a position in um. A model may be in another unit of length.
#pragma once

#include <optional>
#include <string_view>

#include "model/any_model.h"

namespace hystcan::model {

/// The length of nm, um (also with a Greek mu), mm and m in um; none for other units.
std::optional<double> length_um(std::string_view unit);

/// The same model with its output in um. A model whose output is not a length is returned as it is.
AnyParameters in_um(AnyParameters parameters);

}  // namespace hystcan::model
