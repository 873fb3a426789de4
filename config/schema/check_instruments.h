// Whether the keys of a twin's amplifier and sensor agree with each other and with the rest.
#pragma once

#include <cstddef>

#include "config/document/document.h"
#include "config/schema/config.h"

namespace hystcan::config {

/// Of one axis, at its key in [axis.twin]. Throws Error.
void check_instruments(const Document& document, const Config& config, std::size_t axis);

/// command_delay_us of every axis whose setpoints are applied on receipt: within what the bus takes. Of a
/// configuration whose bus is sound. Throws Error.
void check_receipt_delays(const Document& document, const Config& config);

}  // namespace hystcan::config
