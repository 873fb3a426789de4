// What people did, in words, as the `event` of docs/page_protocol.md without its time.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace hystcan::app {

/// `by`: "page 3". The axis is null: the words name it.
nlohmann::json act_event(const std::string& by, const std::string& level, const std::string& text);

/// The events of a command to the controller and of its answer: one for each setting that it has changed, or else one.
std::vector<nlohmann::json> command_events(const std::string& by, const nlohmann::json& command,
                                           const nlohmann::json& answer);

/// One event for each change of a list of `key`, `from`, `to`; of many changes the first ones and their number.
std::vector<nlohmann::json> change_events(const std::string& by, const std::string& what,
                                          const nlohmann::json& changes);

}  // namespace hystcan::app
