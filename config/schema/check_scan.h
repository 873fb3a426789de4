// Checks whether the axes of a scan stay in phase.
#pragma once

#include "config/document/document.h"
#include "config/schema/config.h"

namespace hystcan::config {

/// The rasters of all axes have the same lines, and begin at the same time of each pass. Throws Error at the key in
/// conflict.
void check_scans(const Document& document, const Config& config);

}  // namespace hystcan::config
