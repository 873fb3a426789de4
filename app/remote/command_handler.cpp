#include "app/remote/command_handler.h"

#include <fmt/format.h>

#include "config/schema/config.h"

namespace hystcan::app {

nlohmann::json parse_command(const std::string& line) {
  constexpr int deepest = 8;  // limits the stack that later recursions over the command need
  const auto is_shallow = [](int depth, nlohmann::json::parse_event_t, const nlohmann::json&) {
    return depth <= deepest;
  };
  return nlohmann::json::parse(line, is_shallow, false);
}

using nlohmann::json;

json refusal(const std::string& reason) { return {{"ok", false}, {"error", reason}}; }

std::string text_of(const json& command, const char* key) {
  const auto found = command.find(key);
  if (found == command.end() || !found->is_string())
    throw config::Error(fmt::format("\"{}\" is missing, expected a text", key));
  return *found;
}

double number_of(const json& command, const char* key) {
  const auto found = command.find(key);
  if (found == command.end() || !found->is_number())
    throw config::Error(fmt::format("\"{}\" is missing, expected a number", key));
  return *found;
}

}  // namespace hystcan::app
