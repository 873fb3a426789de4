// What no single key shows: whether the parts of a configuration agree with each other.
#pragma once

#include "config/document/document.h"
#include "config/schema/config.h"

namespace hystcan::config {

/// Node ids, DBC, units, ranges, delays, the time on the bus. Throws Error at the key that is in the way.
void check_agreement(const Document& document, const Config& config);

}  // namespace hystcan::config
