// Checks whether the axis messages, standard or a lab's own, agree with the DBC.
#pragma once

#include <cstddef>

#include "config/document/document.h"
#include "config/schema/config.h"

namespace hystcan::config {

/// Checks messages, signals, identifiers, overlaps, units and ranges. Throws Error at the place of the first
/// disagreement. If a message or signal is missing, the error names the nearest ones of the DBC.
void check_frames(const Document& document, const Config& config, std::size_t axis);

/// Throws Error if two messages that are sent or received, including those of CANopen, share an identifier.
void check_identifiers(const Document& document, const Config& config);

}  // namespace hystcan::config
