#include "config/schema/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>

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

/// Returns a configuration in which every key has its default, for a comparison with `config`. Both
/// configurations have the same number of axes, and each axis has segments of the same kinds. The returned
/// configuration has no optional tables.
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

/// Casts const away, because visit() takes a reference that is not const. Use this only for visit() with a
/// Writer: a Writer reads the value and does not change it.
template <class T>
T& visited(const T& value) {
  return const_cast<T&>(value);
}

/// Calls `take` with each key and each table of a configuration struct.
template <class T>
void for_each_key(const T& value, Writer::Layout layout, const std::function<void(const Key&)>& take) {
  Writer writer(layout, [&](const Key& key, bool /*is_required*/) {
    take(key);
    return std::optional<std::string>();
  });
  visit(writer, visited(value));
}

/// Returns the keys of a configuration struct that have a value. Omits tables, because a table has no value.
template <class T>
std::vector<Setting> keys_of(const T& value, Writer::Layout layout) {
  std::vector<Setting> result;
  for_each_key(value, layout, [&](const Key& key) {
    if (!key.value.empty()) result.push_back(key);
  });
  return result;
}

template <class T>
std::string found_path(const T& value, const Member& member) {
  std::string path;
  for_each_key(value, Writer::Layout::schema, [&](const Key& key) {
    if (key.member == member && path.empty()) path = key.path;
  });
  if (path.empty()) throw std::logic_error("no key of the configuration has this member");
  return path;
}

}  // namespace

std::vector<Setting> settings(const std::filesystem::path& file, const std::vector<Setting>& overrides,
                              const ReadFiles& files) {
  std::vector<Setting> result = keys_of(load_as_written(file, overrides, files), Writer::Layout::plain);
  for (Setting& setting : result)
    if (setting.value.find_first_of("'\\") == std::string::npos)
      std::ranges::replace(setting.value, '"', '\'');
  std::ranges::sort(result, {}, &Setting::path);
  return result;
}

std::vector<Setting> settings(const Config& config) { return keys_of(config, Writer::Layout::columns); }

std::vector<Setting> settings(const controller::Delays& delays) {
  return keys_of(delays, Writer::Layout::columns);
}

std::vector<Key> running_keys(const Config& config) {
  std::vector<Key> result;
  for_each_key(config, Writer::Layout::schema, [&](const Key& key) {
    if (is_taken_over(key.effect) && !key.is_table) result.push_back(key);
  });
  return result;
}

std::string path_of(const Config& config, const Member& member) { return found_path(config, member); }

std::string path_of(const AxisConfig& axis, const Member& member) { return found_path(axis, member); }

std::string key_of(const AxisConfig& axis, const Member& member) {
  const std::string path = path_of(axis, member);
  return path.substr(path.rfind('.') + 1);
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
  visit(writer, visited(config));
  return fmt::format("{}{}", format_line, writer.text());  // writer.text() begins with an empty line
}

std::string control_text(const AxisConfig& axis, const Remark& remark) {
  Writer writer(Writer::Layout::columns, remark, "axis");
  writer.table(control_key, visited(axis), [](Writer& sub, AxisConfig& value) { visit_control(sub, value); });
  return writer.text();
}

void edit(TomlEdit& text, const Config& before, const Config& after) {
  const std::vector<Setting> wanted = settings(after);
  const auto has_keys = [&](const std::string& table) {
    return std::ranges::any_of(wanted, [&](const Setting& key) { return key.path.starts_with(table + "."); });
  };
  for (const Change& change : changes(settings(before), wanted)) {
    const std::string table = change.path.substr(0, change.path.rfind('.'));
    const bool is_off = std::ranges::any_of(after.axes, [&](const AxisConfig& axis) {
      const double& low_pass_Hz = axis.control.law.measurement_filter_Hz;
      return low_pass_Hz == 0.0 && change.path == path_of(after, low_pass_Hz);
    });
    if (!change.to.empty() && !is_off)
      text.set(change.path, change.to);
    else
      text.comment_out(change.to.empty() && !has_keys(table) ? table : change.path);
  }
}

std::vector<Change> changes(const std::vector<Setting>& before, const std::vector<Setting>& after) {
  std::map<std::string, std::string> former = by_path(before);
  std::vector<Change> result;
  for (const Setting& setting : after) {
    const auto old = former.extract(setting.path);
    const std::string from = old.empty() ? std::string() : old.mapped();
    if (from != setting.value) result.push_back({setting.path, from, setting.value, setting.effect});
  }
  for (const Setting& setting : before)
    if (former.contains(setting.path)) result.push_back({setting.path, setting.value, {}, setting.effect});
  return result;
}

std::string describe(const Change& change) {
  const auto shown = [](const std::string& value) { return value.empty() ? std::string("(none)") : value; };
  return fmt::format("{}: {} -> {}", change.path, shown(change.from), shown(change.to));
}

}  // namespace hystcan::config
