// Reads a reference from CSV with the columns time_s and position_um.
#pragma once

#include <filesystem>

#include "controller/reference/motion.h"

namespace hystcan::config {

/// Throws Error, with its line, if the file cannot be read, has fewer than two rows, or if time does not
/// increase.
controller::MonotoneCubic load_setpoint(const std::filesystem::path& file);

}  // namespace hystcan::config
