// Checks whether the parts of a configuration agree with each other.
#pragma once

#include "config/document/document.h"
#include "config/schema/config.h"

namespace hystcan::config {

/// Checks node ids, DBC, units, ranges, delays and the timing of the bus. Throws Error at the key in
/// conflict.
void check_agreement(const Document& document, const Config& config);

}  // namespace hystcan::config
