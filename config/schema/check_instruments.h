// Checks whether the keys of a twin's amplifier and sensor agree with each other and with the rest.
#pragma once

#include <cstddef>

#include "config/document/document.h"
#include "config/schema/config.h"

namespace hystcan::config {

/// Checks one axis. Throws Error at the key in [axis.twin].
void check_instruments(const Document& document, const Config& config, std::size_t axis);

/// Checks command_delay_us of every axis whose setpoints take effect on receipt: more than 0, and at most the
/// latest end of the command on the bus. The bus must have passed check_bus(). Throws Error.
void check_receipt_delays(const Document& document, const Config& config);

}  // namespace hystcan::config
