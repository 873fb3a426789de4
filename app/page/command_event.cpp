#include "app/page/command_event.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "config/schema/settings.h"

namespace hystcan::app {
namespace {

using nlohmann::json;

constexpr std::size_t most_changes = 20;
constexpr std::size_t longest_words = 200;

std::string dumped(const json& command, const char* key) {
  return command.value(key, json()).dump(-1, ' ', false, json::error_handler_t::replace);
}

/// "x: go to 12.5 um".
std::string words_of_command(const json& command) {
  const std::string what = command.at("do");
  const bool has_axis = command.contains("axis") && command.at("axis").is_string();
  std::string words = has_axis ? command.at("axis").get<std::string>() + ": " : std::string();
  if (what == "go_to")
    words += fmt::format("go to {} um", dumped(command, "position_um"));
  else if (what == "set")
    words += fmt::format("set {} = {}", dumped(command, "key"), dumped(command, "value"));
  else if (what == "record")
    words += command.value("on", json()) == true ? "record" : "end the recording";
  else
    words += what;
  return words.substr(0, longest_words);
}

}  // namespace

json act_event(const std::string& by, const std::string& level, const std::string& text) {
  return {{"type", "event"}, {"axis", nullptr}, {"by", by}, {"level", level}, {"text", text}};
}

std::vector<json> change_events(const std::string& by, const std::string& what, const json& changes) {
  std::vector<json> events;
  for (std::size_t i = 0; i < std::min(changes.size(), most_changes); ++i) {
    const config::Change change{changes[i].at("key"), changes[i].at("from"), changes[i].at("to")};
    events.push_back(act_event(by, "info", fmt::format("{} {}", what, describe(change))));
    events.back().update({{"key", change.path}, {"from", change.from}, {"to", change.to}});
  }
  if (changes.size() > most_changes)
    events.push_back(
        act_event(by, "info", fmt::format("{}: {} more keys", what, changes.size() - most_changes)));
  return events;
}

std::vector<json> command_events(const std::string& by, const json& command, const json& answer) {
  const std::string words = words_of_command(command);
  if (!answer.value("ok", false))
    return {act_event(by, "warning", fmt::format("{}: refused: {}", words, answer.value("error", "")))};
  if (const auto changed = answer.find("changed"); changed != answer.end() && !changed->empty())
    return change_events(by, command.at("do"), *changed);
  const std::string run = answer.value("run", "");
  return {act_event(by, command.at("do") == "stop" ? "warning" : "info",
                    run.empty() ? words : fmt::format("{}: {}", words, run))};
}

}  // namespace hystcan::app
