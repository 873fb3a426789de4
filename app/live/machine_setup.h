// What a run on a real bus asks of the machine before it begins.
#pragma once

#include <string>

#include "config/schema/config.h"

namespace hystcan::app {

/// Logs the settings of the interface, with a warning for each doubtful one. Throws RunError if the
/// interface cannot serve a node that sends.
void check_interface(const config::Config& config, const std::string& interface);

/// Applies [controller.realtime] to this thread and logs a warning for each setting that is refused. Threads
/// that exist already keep their settings.
void become_realtime(const config::Config& config);

}  // namespace hystcan::app
