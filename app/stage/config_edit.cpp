#include "app/stage/config_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <system_error>

#include "base/output_file.h"
#include "config/document/toml_edit.h"
#include "config/schema/settings.h"

namespace hystcan::app {
namespace {

using Values = std::map<std::string, std::string>;

/// Returns the settings in [axis.control] of an axis, as a map from the path of a key to its value.
Values values_of(const config::AxisConfig& axis) {
  Values values;
  config::control_text(axis, [&](const config::Key& key, bool /*is_required*/) {
    if (!key.value.empty()) values[key.path] = key.value;
    return std::optional<std::string>();
  });
  return values;
}

std::string table_of(const std::string& path) { return path.substr(0, path.rfind('.')); }

/// Returns a line "# remove [TABLE]" for each table that has keys in `before` but none in `after`.
std::string removals(const Values& before, const Values& after) {
  std::set<std::string> removed_tables;
  for (const auto& [path, value] : before) removed_tables.insert(table_of(path));
  for (const auto& [path, value] : after) removed_tables.erase(table_of(path));
  std::string text;
  for (const std::string& table : removed_tables) text += fmt::format("# remove [{}]\n", table);
  return text;
}

}  // namespace

controller::Delays in_whole_microseconds(controller::Delays delays) {
  for (std::chrono::nanoseconds* delay : {&delays.command_delay, &delays.sensor_delay})
    *delay = std::chrono::round<std::chrono::microseconds>(*delay);
  return delays;
}

void set_loop(controller::AxisConfig& axis, const controller::LoopConfig& loop) {
  axis.law.pi = loop.pi;
  axis.law.measurement_filter_Hz = loop.measurement_filter_Hz;
  axis.law.notch = loop.notch;
  axis.delays = loop.delays;
}

std::string with_loop(const config::Config& config, std::size_t axis, controller::LoopConfig loop) {
  config::TomlEdit text = config::TomlEdit::of_file(config.file);
  config::Config changed = config;
  loop.delays = in_whole_microseconds(loop.delays);
  set_loop(changed.axes[axis].control, loop);
  edit(text, config, changed);
  return text.text();
}

std::string control_fragment(const config::AxisConfig& before, const config::AxisConfig& after,
                             const Notes& notes) {
  const Values former = values_of(before);
  const std::string text = config::control_text(
      after, [&](const config::Key& key, bool /*is_required*/) -> std::optional<std::string> {
        if (key.value.empty()) return std::nullopt;
        const auto was = former.find(key.path);
        const auto note = std::ranges::find(notes, key.member, &Notes::value_type::first);
        if (note == notes.end() && was != former.end() && was->second == key.value) return std::nullopt;
        const std::string suffix = note == notes.end() ? std::string() : note->second;
        if (was != former.end()) return "was " + was->second + suffix;
        return suffix.substr(std::min(suffix.find_first_not_of("; "), suffix.size()));
      });
  return text + removals(former, values_of(after));
}

std::size_t index_of_axis(const config::Config& config, const std::string& name) {
  if (name.empty()) return 0;
  const auto found = std::ranges::find(config.axes, name, [](const auto& axis) { return axis.wire.name; });
  if (found == config.axes.end())
    throw Error(config.file, fmt::format("no axis {}", name), expect("an axis of this file"));
  return static_cast<std::size_t>(found - config.axes.begin());
}

void refuse_to_overwrite_inputs(const std::filesystem::path& output, const std::filesystem::path& file,
                                const config::Config& config) {
  const auto folder = file.parent_path();
  refuse_to_overwrite(output, file);
  refuse_to_overwrite(output, folder / config.bus.dbc);
  for (const config::AxisConfig& axis : config.axes)
    for (const auto& model : {axis.control_model, axis.twin_model})
      refuse_to_overwrite(output, folder / model);
}

void refuse_to_write_into(const std::filesystem::path& written, const config::Config& config,
                          const std::filesystem::path& output, const std::filesystem::path& data) {
  refuse_to_overwrite_inputs(written, config.file, config);
  refuse_to_share(written, output);
  if (!data.empty()) refuse_to_overwrite(written, data);
  if (std::filesystem::exists(written)) throw Error(written, "exists already", expect("a new file"));
  const auto folder = [](const std::filesystem::path& file) {
    std::error_code ignored;
    return std::filesystem::weakly_canonical(std::filesystem::absolute(file, ignored), ignored).parent_path();
  };
  if (folder(written) != folder(config.file))
    throw Error(written, fmt::format("is not in the folder of {}", config.file.string()),
                expect("a file in that folder, because the paths in the file are relative"));
}

}  // namespace hystcan::app
