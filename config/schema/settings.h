// The configuration as a flat list with one setting per key, and the changes between two lists; the
// configuration as the text of a file.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/config.h"

namespace hystcan::config {

/// Returns all keys in force by name, defaults included, with the values in the file. Throws Error.
std::vector<Setting> settings(const std::filesystem::path& file, const std::vector<Setting>& overrides = {},
                              const ReadFiles& files = {});
/// Returns the keys of a configuration in memory, with their values as in a file.
std::vector<Setting> settings(const Config& config);
/// Returns the keys of [axis.control.delays].
std::vector<Setting> settings(const controller::Delays& delays);

/// Returns the keys that can change while the controller runs, including keys that are not in the file.
std::vector<Key> running_keys(const Config& config);

/// Returns the path of the key or table with this member: "axis[0].control.kp". Throws std::logic_error if no
/// `visit` contains the member.
std::string path_of(const Config& config, const Member& member);
/// Returns the path within an axis: "control.kp".
std::string path_of(const AxisConfig& axis, const Member& member);
/// Returns only the key: "kp".
std::string key_of(const AxisConfig& axis, const Member& member);

struct Change {
  std::string path;
  std::string from;  ///< old value as TOML; empty if the key is new
  std::string to;    ///< new value as TOML; empty if the key was removed
  Effect effect = Effect::after_restart;
};
std::vector<Change> changes(const std::vector<Setting>& before, const std::vector<Setting>& after);

/// Returns "axis[0].control.kp: 0.05 -> 0.08".
std::string describe(const Change& change);

/// Returns the text of a file: the required keys, the keys that differ from their defaults, and the keys
/// whose path has a remark, which may be empty.
std::string file_text(const Config& config, const std::map<std::string, std::string>& remarks);

/// Returns the keys of [axis.control] that have a remark; their paths begin with "axis.control".
std::string control_text(const AxisConfig& axis, const Remark& remark);

class TomlEdit;
/// Changes the text of configuration `before` into the text of `after`. An unchanged key keeps its line.
/// Comments out a key that was removed, a low pass that is now zero, and a table without keys.
void edit(TomlEdit& text, const Config& before, const Config& after);

}  // namespace hystcan::config
