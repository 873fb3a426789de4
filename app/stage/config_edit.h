// Changes the control loop of one axis in a configuration, and in the text of its file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "config/schema/config.h"
#include "controller/analysis/loop_design.h"

namespace hystcan::app {

/// Rounds the pure delays to whole microseconds, because a configuration file stores whole microseconds.
controller::Delays in_whole_microseconds(controller::Delays delays);
/// Copies gains, filters and delays of `loop` into the axis. Changes no file.
void set_loop(controller::AxisConfig& axis, const controller::LoopConfig& loop);

/// Returns the index of the axis with this name; 0 if `name` is empty. Throws Error if there is no such axis.
std::size_t index_of_axis(const config::Config& config, const std::string& name);

/// Returns the text of the configuration file with `loop` in the table [axis.control] of this axis. All other
/// lines are unchanged.
std::string with_loop(const config::Config& config, std::size_t axis, controller::LoopConfig loop);

/// Pairs of a setting of an axis and a remark about it, for example "; one cycle".
using Notes = std::vector<std::pair<config::Member, std::string>>;

/// Returns lines for [axis.control]: the keys whose value differs from `before`, and the keys that have a
/// note. The comment after a key contains its former value and its note, for example "# was 0.1; one cycle".
std::string control_fragment(const config::AxisConfig& before, const config::AxisConfig& after,
                             const Notes& notes);

/// Throws Error if the file `written` exists, is an input, or equals `output`. Also throws if `written` is in
/// another folder than the configuration, because its relative paths would then be wrong. `data`: another
/// input file; may be empty.
void refuse_to_write_into(const std::filesystem::path& written, const config::Config& config,
                          const std::filesystem::path& output, const std::filesystem::path& data = {});

/// Throws Error if `output` is the configuration `file`, its DBC, or one of its model files.
void refuse_to_overwrite_inputs(const std::filesystem::path& output, const std::filesystem::path& file,
                                const config::Config& config);

}  // namespace hystcan::app
