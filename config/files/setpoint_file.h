// A reference as a file: CSV with the columns time_s and position_um.
#pragma once

#include <filesystem>

#include "controller/reference/monotone_cubic.h"

namespace hystcan::config {

/// Throws Error, at its line, where the file can't be read, has fewer than two rows, or time does not
/// increase.
controller::MonotoneCubic load_setpoint(const std::filesystem::path& file);

}  // namespace hystcan::config
