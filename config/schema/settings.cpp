#include "config/schema/settings.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <map>
#include <sstream>

#include "config/document/toml_edit.h"
#include "config/document/toml_text.h"
#include "config/schema/schema.h"

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

/// As many axes and segments, of the same kinds, with their defaults and without tables that may be left out.
Config defaults_of(const Config& config) {
  Config defaults;
  for (const AxisConfig& axis : config.axes) {
    AxisConfig& usual = defaults.axes.emplace_back();
    usual.wire.drive_unit = axis.wire.drive_unit;
    for (const controller::Segment& segment : axis.control.setpoint)
      usual.control.setpoint.push_back(
          {.shape = controller::shape_of_kind(controller::to_string(segment.shape))});
  }
  return defaults;
}

/// Keys that a running axis cannot exchange.
constexpr std::array foundations{std::string_view("model")};

}  // namespace

std::vector<Setting> settings(const std::filesystem::path& file, const std::vector<Setting>& overrides) {
  std::vector<Setting> result;
  collect(parse_toml(echo(file, overrides), file.string()), "", result);
  return result;
}

std::vector<Setting> settings(const Config& config) {
  std::vector<Setting> result;
  Writer writer(Writer::Layout::columns, [&](const Setting& key, bool /*is_required*/) {
    if (!key.value.empty()) result.push_back(key);
    return std::optional<std::string>();
  });
  Config visited = config;
  visit(writer, visited);
  return result;
}

std::string file_text(const Config& config, const std::map<std::string, std::string>& remarks) {
  const std::map<std::string, std::string> defaults = by_path(settings(defaults_of(config)));
  Writer writer(Writer::Layout::columns, [&](const Setting& key, bool is_required) {
    const auto remark = remarks.find(key.path);
    if (remark != remarks.end()) return std::optional(remark->second);
    const auto usual = defaults.find(key.path);
    const bool is_usual = key.value.empty() || (usual != defaults.end() && usual->second == key.value);
    return is_required || !is_usual ? std::optional<std::string>("") : std::nullopt;
  });
  Config visited = config;
  visit(writer, visited);
  return writer.text();
}

std::string control_text(const AxisConfig& axis, const Remark& remark) {
  Writer writer(Writer::Layout::columns, remark, "axis");
  AxisConfig visited = axis;
  writer.table("control", visited, [](Writer& sub, AxisConfig& value) { visit_control(sub, value); });
  return writer.text();
}

void edit(TomlEdit& text, const Config& before, const Config& after) {
  const std::vector<Setting> wanted = settings(after);
  const auto has_keys = [&](const std::string& table) {
    return std::ranges::any_of(wanted, [&](const Setting& key) { return key.path.starts_with(table + "."); });
  };
  for (const Change& change : changes(settings(before), wanted)) {
    const std::string table = change.path.substr(0, change.path.rfind('.'));
    const bool is_off = change.path.ends_with(".measurement_filter_Hz") && change.to == "0.0";
    if (!change.to.empty() && !is_off)
      text.set(change.path, change.to);
    else
      text.comment_out(change.to.empty() && !has_keys(table) ? table : change.path);
  }
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
