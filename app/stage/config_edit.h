// Gains, filters and delays of one axis in the text of a configuration.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "config/schema/config.h"
#include "controller/analysis/loop_design.h"

namespace hystcan::app {

/// What a loop is set by.
struct LoopKeys {
  controller::LoopSetting setting;
  controller::Delays delays;
};
LoopKeys loop_keys_of(const config::AxisConfig& axis);

/// Index of the axis with this name; 0 if it is empty. Throws Error if there is none.
std::size_t index_of_axis(const config::Config& config, const std::string& name);

/// The text of the configuration with `keys` in [axis.control] of this axis. A key that keeps its value keeps its line;
/// a notch or a low pass that is no longer used is commented out.
std::string with_loop_keys(const config::Config& config, std::size_t axis, const LoopKeys& keys);

/// Throws Error if `written` is an input or another output, or does not lie in the folder of the configuration:
/// the paths within it count from there. `data` may be empty.
void refuse_to_write_into(const std::filesystem::path& written, const config::Config& config,
                          const std::filesystem::path& output, const std::filesystem::path& data = {});

/// Throws Error if `output` is one of the files that the configuration was read from.
void refuse_to_overwrite_inputs(const std::filesystem::path& output, const std::filesystem::path& file,
                                const config::Config& config);

}  // namespace hystcan::app
