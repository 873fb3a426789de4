#include "app/live/command_handler.h"

#include <fmt/format.h>

#include "config/schema/config.h"

namespace hystcan::app {

nlohmann::json parse_command(const std::string& line) {
  constexpr int deepest = 8;  // limits the stack that later recursions over the command need
  bool is_deep = false;
  const auto is_kept = [&is_deep](int depth, nlohmann::json::parse_event_t, const nlohmann::json&) {
    is_deep = is_deep || depth > deepest;
    return !is_deep;
  };
  nlohmann::json command = nlohmann::json::parse(line, is_kept, false);
  return is_deep ? nlohmann::json() : command;
}

using nlohmann::json;

json refusal(const std::string& reason) { return {{"ok", false}, {"error", reason}}; }

std::string text_of(const json& command, const char* key) {
  const auto found = command.find(key);
  if (found == command.end() || !found->is_string())
    throw Error(fmt::format("\"{}\" is missing, expected a text", key));
  return *found;
}

double number_of(const json& command, const char* key) {
  const auto found = command.find(key);
  if (found == command.end() || !found->is_number())
    throw Error(fmt::format("\"{}\" is missing, expected a number", key));
  return *found;
}

json to_json(const std::vector<config::Change>& changes) {
  json list = json::array();
  for (const config::Change& change : changes)
    list.push_back({{"key", change.path}, {"from", change.from}, {"to", change.to}});
  return list;
}

std::vector<config::Change> changes_of(const json& list) {
  std::vector<config::Change> changes;
  changes.reserve(list.size());
  for (const json& change : list) changes.push_back({change.at("key"), change.at("from"), change.at("to")});
  return changes;
}

}  // namespace hystcan::app
