// The state of a running controller as lines of text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace hystcan::app {

/// "-" if there is no number.
std::string four_decimals(const nlohmann::json& value);

/// Of the answer to `status` (docs/control_socket.md): counters, recording, a row for each axis. Not cut to
/// any width.
std::vector<std::string> status_lines(const nlohmann::json& status);

/// The same for a screen: with timing, the last event of a node, and the interface (docs/page_protocol.md:
/// `bus`). `status` may be null: no answer has come, and `trouble` says why.
std::vector<std::string> status_screen(const nlohmann::json& status, const nlohmann::json& bus,
                                       const std::string& trouble);

}  // namespace hystcan::app
