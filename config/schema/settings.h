// Converts a configuration into a flat list with one setting per key, or into the text of a file. Also finds
// the changes between two lists of settings.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/config.h"

namespace hystcan::config {

/// Returns all keys of the configuration in `file`, sorted by path, with their values. Defaults are included.
/// Throws Error if the configuration is invalid.
std::vector<Setting> settings(const std::filesystem::path& file, const std::vector<Setting>& overrides = {},
                              const ReadFiles& files = {});
/// Returns the keys of a configuration in memory, with their values as they would be written in a file.
std::vector<Setting> settings(const Config& config);
/// Returns the keys of the table [axis.control.delays] with their values.
std::vector<Setting> settings(const controller::Delays& delays);

/// Returns all keys that can change while the controller runs. Keys that the file does not set are included.
std::vector<Key> running_keys(const Config& config);

/// Returns the path of the key or table that sets this member of the configuration: "axis[0].control.kp".
/// Throws std::logic_error if no key sets the member.
std::string path_of(const Config& config, const Member& member);
/// Returns the path of the key that sets this member, relative to the axis: "control.kp".
std::string path_of(const AxisConfig& axis, const Member& member);
/// Returns the name of the key that sets this member, without its path: "kp".
std::string key_of(const AxisConfig& axis, const Member& member);

struct Change {
  std::string path;
  std::string from;  ///< old value as TOML; empty if the key is new
  std::string to;    ///< new value as TOML; empty if the key was removed
  Effect effect = Effect::after_restart;
};
std::vector<Change> changes(const std::vector<Setting>& before, const std::vector<Setting>& after);

/// Returns the change in words, for example "axis[0].control.kp: 0.05 -> 0.08".
std::string describe(const Change& change);

/// Returns the text of a configuration file. It has the required keys, the keys that differ from their
/// defaults, and the keys in `remarks`. `remarks` maps the path of a key to a comment, which is written after
/// the value of the key. An empty comment is allowed: the key is then written without a comment.
std::string file_text(const Config& config, const std::map<std::string, std::string>& remarks);

/// Returns the text of the table [axis.control]. Calls `remark` for each key of this table, with a path such
/// as "axis.control.kp". The text contains only the keys for which `remark` returns a comment.
std::string control_text(const AxisConfig& axis, const Remark& remark);

class TomlEdit;
/// Changes `text`, the file of the configuration `before`, so that it describes the configuration `after`.
/// The lines of unchanged keys stay as they are. Comments out a key that `after` lacks, a table whose keys
/// are all removed, and the key measurement_filter_Hz if its new value is 0 (no filter).
void edit(TomlEdit& text, const Config& before, const Config& after);

}  // namespace hystcan::config
