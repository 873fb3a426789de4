// Do the axis messages, standard or a lab's own, agree with the DBC?
#pragma once

#include <cstddef>

#include "config/document/document.h"

namespace hystcan::config {

/// Throws Error at the place of the first disagreement: a message or signal that the DBC lacks (with what it
/// offers), identifiers, overlaps, units, ranges.
void check_frames(const Document& document, const Config& config, std::size_t axis);

/// No two messages that are sent or heard may share an identifier, CANopen's own included.
void check_identifiers(const Document& document, const Config& config);

}  // namespace hystcan::config
