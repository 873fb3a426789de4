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

/// All keys in force, including defaults, by their names, with the values that the file has. Throws Error.
std::vector<Setting> settings(const std::filesystem::path& file, const std::vector<Setting>& overrides = {},
                              const ReadFiles& files = {});
/// The keys of a configuration in memory, with their values as a file has them.
std::vector<Setting> settings(const Config& config);
/// Those of [axis.control.delays].
std::vector<Setting> settings(const controller::Delays& delays);

/// The keys that can change while the controller runs, also those that are left out.
std::vector<Key> running_keys(const Config& config);

/// The path of the key, or of the table, that has this member: "axis[0].control.kp". Throws std::logic_error
/// if no `visit` names the member.
std::string path_of(const Config& config, const Member& member);
/// The same within an axis: "control.kp".
std::string path_of(const AxisConfig& axis, const Member& member);
/// The key alone: "kp".
std::string key_of(const AxisConfig& axis, const Member& member);

struct Change {
  std::string path;
  std::string from;  ///< as TOML; empty if the key is new
  std::string to;    ///< as TOML; empty if the key is gone
  Effect effect = Effect::after_restart;
};
std::vector<Change> changes(const std::vector<Setting>& before, const std::vector<Setting>& after);

/// "axis[0].control.kp: 0.05 -> 0.08".
std::string describe(const Change& change);

/// The text of a file: the required keys, those that differ from their defaults, and those with a remark,
/// which may be empty, at their path.
std::string file_text(const Config& config, const std::map<std::string, std::string>& remarks);

/// The keys of [axis.control] that have a remark; their paths begin with "axis.control".
std::string control_text(const AxisConfig& axis, const Remark& remark);

class TomlEdit;
/// Makes the text, which is that of `before`, that of `after`. A key that keeps its value keeps its line. A
/// key that is gone, a low pass that has become zero, and a table without keys are commented out.
void edit(TomlEdit& text, const Config& before, const Config& after);

}  // namespace hystcan::config
