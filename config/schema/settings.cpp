#include "config/schema/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>

#include "config/document/format.h"
#include "config/document/toml_edit.h"
#include "config/schema/schema.h"

namespace hystcan::config {
namespace {

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

/// Keys that a running axis cannot exchange. The frames of the commands get the safe drive at the start.
bool is_foundation(std::string_view key) { return key == "model" || key.starts_with("safe_drive_"); }

/// The keys that have a value.
std::vector<Setting> keys_of(Config config, Writer::Layout layout) {
  std::vector<Setting> result;
  Writer writer(layout, [&](const Key& key, bool /*is_required*/) {
    if (!key.value.empty()) result.push_back(key);
    return std::optional<std::string>();
  });
  visit(writer, config);
  return result;
}

}  // namespace

std::vector<Setting> settings(const std::filesystem::path& file, const std::vector<Setting>& overrides) {
  std::vector<Setting> result = keys_of(load_as_written(file, overrides), Writer::Layout::plain);
  for (Setting& setting : result)
    if (setting.value.find_first_of("'\\") == std::string::npos)
      std::ranges::replace(setting.value, '"', '\'');
  std::ranges::sort(result, {}, &Setting::path);
  return result;
}

std::vector<Setting> settings(const Config& config) { return keys_of(config, Writer::Layout::columns); }

std::vector<Key> running_keys(const Config& config) {
  std::vector<Key> result;
  Writer writer(Writer::Layout::schema, [&](const Key& key, bool /*is_required*/) {
    if (effect_of(key.path) == Effect::at_once) result.push_back(key);
    return std::optional<std::string>();
  });
  Config visited = config;
  visit(writer, visited);
  return result;
}

std::string unit_of(std::string_view key) {
  constexpr std::pair<std::string_view, std::string_view> units[] = {
      {"um", "um"},   {"s", "s"},   {"ms", "ms"},  {"us", "us"},        {"hour", "h"},    {"h", "h"},
      {"Hz", "Hz"},   {"V", "V"},   {"A", "A"},    {"K", "K"},          {"percent", "%"}, {"deg", "deg"},
      {"ppm", "ppm"}, {"MB", "MB"}, {"GB", "GB"},  {"uF", "uF"},        {"mH", "mH"},     {"ohm", "ohm"},
      {"bit", "bit"}, {"<U>", "U"}, {"s2", "s^2"}, {"rtHz", "sqrt(Hz)"}};
  key.remove_prefix(key.rfind('.') + 1);  // nothing where it is no path
  if (key == "kp") return "um/um";
  if (key.ends_with("_rms")) key.remove_suffix(4);
  const auto unit_at_end = [&](std::string_view text) {
    const std::string_view word = text.substr(text.rfind('_') + 1);
    const auto found = std::ranges::find(units, word, [](const auto& unit) { return unit.first; });
    return found == std::end(units) ? std::string() : std::string(found->second);
  };
  std::string unit = unit_at_end(key);
  const std::size_t per = key.rfind("_per_");
  if (unit.empty() || per == std::string_view::npos || key.find('_', per + 5) != std::string_view::npos)
    return unit;
  const std::string above = unit_at_end(key.substr(0, per));
  return (above.empty() ? "1" : above) + "/" + unit;
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
  return fmt::format("{}{}", format_line, writer.text());  // the text begins with an empty line
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
  return is_foundation(path) ? Effect::after_restart : Effect::at_once;
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
