// Prepares this computer for a run on a real bus.
#pragma once

#include <string>

#include "config/schema/config.h"

namespace hystcan::app {

/// Logs the settings of the CAN interface, and a warning for each doubtful setting. Throws RunError if the
/// interface cannot send the configured frames.
void check_interface(const config::Config& config, const std::string& interface);

/// Applies the table [controller.realtime] to the calling thread. Logs a warning for each setting that the
/// system refuses. Threads that already exist keep their settings.
void become_realtime(const config::Config& config);

}  // namespace hystcan::app
