// Prepares the machine for a run on a real bus.
#pragma once

#include <string>

#include "config/schema/config.h"

namespace hystcan::app {

/// Logs the settings of the interface, with a warning for each doubtful one. Throws RunError if the interface
/// can't be used by a node that sends.
void check_interface(const config::Config& config, const std::string& interface);

/// Applies [controller.realtime] to this thread and logs a warning for each refused setting. Existing threads
/// keep their settings.
void become_realtime(const config::Config& config);

}  // namespace hystcan::app
