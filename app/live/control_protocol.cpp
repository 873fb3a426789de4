#include "app/live/control_protocol.h"

#include <fmt/format.h>

#include "app/live/answer_json.h"
#include "base/error.h"

namespace hystcan::app {

using nlohmann::json;

json command_of(Verb verb) { return {{"do", row_of(verb).word}}; }

const ControlCommand* find_command(const json& command, Server server) {
  const auto what = command.find("do");
  if (what == command.end()) return nullptr;
  for (const ControlCommand& row : protocol::commands)
    if (*what == row.word && row.reply_of(server) != Reply::none) return &row;
  return nullptr;
}

const ControlCommand& take_command(const json& command, Server server) {
  const std::string what = text_of(command, "do");
  if (const ControlCommand* row = find_command(command, server)) return *row;
  std::string expected;
  for (int i = 0; i < static_cast<int>(Verb::stop); ++i) {
    const ControlCommand& row = row_of(static_cast<Verb>(i));
    if (row.reply_of(server) != Reply::none) expected += fmt::format("{}, ", row.word);
  }
  expected.resize(expected.size() - 2);
  throw Error(fmt::format("\"{}\" is not a command", what), expect("{} or stop", expected));
}

nlohmann::json parse_command(const std::string& line) {
  constexpr int deepest = 8;  // maximum nesting of JSON, so that later recursions cannot exhaust the stack
  bool is_deep = false;
  const auto is_kept = [&is_deep](int depth, nlohmann::json::parse_event_t, const nlohmann::json&) {
    is_deep = is_deep || depth > deepest;
    return !is_deep;
  };
  nlohmann::json command = nlohmann::json::parse(line, is_kept, false);
  return is_deep ? nlohmann::json() : command;
}

json refusal(const std::string& reason) { return answer_json(RefusedAnswer{.error = reason}); }

std::string text_of(const json& command, const char* key) {
  const auto found = command.find(key);
  if (found == command.end() || !found->is_string())
    throw Error(fmt::format("\"{}\" is missing", key), expect("a text"));
  return *found;
}

double number_of(const json& command, const char* key) {
  const auto found = command.find(key);
  if (found == command.end() || !found->is_number())
    throw Error(fmt::format("\"{}\" is missing", key), expect("a number"));
  return *found;
}

}  // namespace hystcan::app
