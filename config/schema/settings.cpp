#include "config/schema/settings.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <map>
#include <sstream>

#include "config/document/toml_text.h"

namespace hystcan::config {
namespace {

/// The value as text; a number has the fewest digits that are exact.
std::string text_of(const toml::node& value) {
  if (const auto* number = value.as_floating_point()) return fmt::format("{}", number->get());
  if (const toml::array* list = value.as_array()) {
    std::vector<std::string> elements;
    elements.reserve(list->size());
    for (const toml::node& element : *list) elements.push_back(text_of(element));
    return fmt::format("[{}]", fmt::join(elements, ", "));
  }
  std::ostringstream text;
  value.visit([&](const auto& node) { text << node; });
  return text.str();
}

bool is_list_of_tables(const toml::node& node) {
  return node.is_array() && node.as_array()->is_array_of_tables();
}

void collect(const toml::node& node, const std::string& path, std::vector<Setting>& into) {
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table)
      collect(value, path.empty() ? std::string(key.str()) : path + "." + std::string(key.str()), into);
  } else if (is_list_of_tables(node)) {
    const toml::array& list = *node.as_array();
    for (std::size_t i = 0; i < list.size(); ++i) collect(list[i], fmt::format("{}[{}]", path, i), into);
  } else {
    into.push_back({path, text_of(node)});
  }
}

std::map<std::string, std::string> by_path(const std::vector<Setting>& settings) {
  std::map<std::string, std::string> result;
  for (const Setting& setting : settings) result[setting.path] = setting.value;
  return result;
}

/// Keys that a running axis cannot exchange.
constexpr std::array foundations{std::string_view("model")};

}  // namespace

std::vector<Setting> settings(const std::filesystem::path& file, const std::vector<Setting>& overrides) {
  std::vector<Setting> result;
  collect(parse_toml(echo(file, overrides), file.string()), "", result);
  return result;
}

Effect effect_of(std::string_view path) {
  if (path.starts_with("twin.")) return Effect::on_twin;
  if (!path.starts_with("axis[")) return Effect::after_restart;
  path.remove_prefix(std::min(path.find("].") + 2, path.size()));
  if (path.starts_with("twin.")) return Effect::on_twin;
  constexpr std::string_view control = "control.";
  if (!path.starts_with(control)) return Effect::after_restart;
  path.remove_prefix(control.size());
  return std::ranges::find(foundations, path) == foundations.end() ? Effect::at_once : Effect::after_restart;
}

std::vector<Change> changes(const std::vector<Setting>& before, const std::vector<Setting>& after) {
  const auto old_values = by_path(before);
  const auto new_values = by_path(after);
  std::vector<Change> result;
  for (const Setting& setting : after) {
    const auto old = old_values.find(setting.path);
    const std::string from = old == old_values.end() ? std::string() : old->second;
    if (from != setting.value) result.push_back({setting.path, from, setting.value});
  }
  for (const Setting& setting : before)
    if (!new_values.contains(setting.path)) result.push_back({setting.path, setting.value, {}});
  return result;
}

std::string describe(const Change& change) {
  const auto shown = [](const std::string& value) { return value.empty() ? std::string("(none)") : value; };
  return fmt::format("{}: {} -> {}", change.path, shown(change.from), shown(change.to));
}

}  // namespace hystcan::config
