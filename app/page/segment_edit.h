// Segments of a setpoint that were added or removed, as an edit of the configuration file's text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace hystcan::app {

/// The text with the segments that `unsaved` adds, behind the last one of their axis, and with `# ` before the lines of
/// those that it removes. What it tells of them is taken out of `unsaved`.
std::string with_segments(const std::string& text, const std::string& name, nlohmann::json& unsaved);

}  // namespace hystcan::app
