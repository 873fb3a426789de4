// Edits the loop of one axis in a configuration and in its text.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "config/schema/config.h"
#include "controller/analysis/loop_design.h"

namespace hystcan::app {

/// Rounds pure delays to whole microseconds, as a configuration file stores them.
controller::Delays in_whole_microseconds(controller::Delays delays);
/// Sets gains, filters and delays of an axis in memory.
void set_loop(controller::AxisConfig& axis, const controller::LoopConfig& loop);

/// Index of the axis with this name; 0 if it is empty. Throws Error if there is none.
std::size_t index_of_axis(const config::Config& config, const std::string& name);

/// Returns the text of the configuration file with this loop in [axis.control] of the axis. All other lines
/// are unchanged.
std::string with_loop(const config::Config& config, std::size_t axis, controller::LoopConfig loop);

/// Notes about members of an axis, for example "; one cycle".
using Notes = std::vector<std::pair<config::Member, std::string>>;

/// Returns a fragment with the keys of [axis.control] that differ from `before`, and those keys of `after`
/// that have a note. The comment after each key contains its former value and its note: "# was 0.1; one
/// cycle".
std::string control_fragment(const config::AxisConfig& before, const config::AxisConfig& after,
                             const Notes& notes);

/// Throws Error if `written` is an input or another output, or if it is not in the folder of the
/// configuration, because its paths are relative to that folder. `data` may be empty.
void refuse_to_write_into(const std::filesystem::path& written, const config::Config& config,
                          const std::filesystem::path& output, const std::filesystem::path& data = {});

/// Throws Error if `output` is one of the files from which the configuration was read.
void refuse_to_overwrite_inputs(const std::filesystem::path& output, const std::filesystem::path& file,
                                const config::Config& config);

}  // namespace hystcan::app
