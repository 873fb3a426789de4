// The configuration of a running controller: the settings in force, and the changes that a new version of the
// file or a command `set` would cause. This class prepares changes but does not apply them. The caller
// applies all prepared changes, or none if one of them needs a restart, because the file is valid only as a
// whole.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/config.h"
#include "config/schema/settings.h"
#include "controller/requests.h"

namespace hystcan::app {

class LiveConfig {
 public:
  /// `config`: the configuration at the start of the process. `files`: the file cache that was filled when
  /// `config` was loaded, so that unchanged files are not read again.
  LiveConfig(std::filesystem::path file, const config::Config& config, config::ReadFiles files = {});

  /// The settings that override the file. The first element is for the file alone (no overrides). Each
  /// command `set` adds an element with all overrides. The last element is in force.
  using History = std::vector<std::vector<config::Setting>>;

  struct Prepared {
    std::vector<config::Setting> settings;  ///< all settings after the change is applied
    History history;
    std::vector<config::Change> at_once{};
    std::vector<config::Change> after_restart{};
    /// Requests to the control thread, one for each axis that must apply new settings.
    std::vector<std::unique_ptr<controller::Request>> requests{};
  };
  /// Prepares the change to the current content of the file, which discards the changes of all `set`
  /// commands. Throws Error if the file is invalid.
  Prepared reread() const;
  /// Prepares the change of one key in [axis.control], for example "kp" or "delays.resonance_Hz".
  Prepared with(std::string_view axis, std::string_view key, const std::string& toml_value) const;
  /// Prepares to undo the last command `set`. Throws Error if no `set` was executed since the file was read.
  Prepared without_the_last() const;
  /// Makes `prepared` the settings in force. Call this function after every axis applied its request.
  void accept(const Prepared& prepared);
  /// Call this function if an axis refused `prepared`, because other axes may have applied it. With the next
  /// change, all settings are sent again to every axis that `prepared` affects.
  void mark_uncertain(const Prepared& prepared);

  const std::filesystem::path& file() const { return file_; }
  const std::vector<config::Setting>& settings() const { return settings_; }
  /// Returns the settings in the current file. The file is read again only if it changed. Throws Error if it
  /// is invalid.
  std::vector<config::Setting> settings_of_file() const { return config::settings(file_, {}, files_); }
  std::size_t single_settings() const { return history_.size() - 1; }
  const std::vector<std::string>& axis_names() const { return names_; }
  /// Returns the index of the axis. Throws Error if no axis has this name.
  std::size_t axis_index(std::string_view name) const;

 private:
  /// The axes whose settings change, by index. The value is true if the change restarts the reference of the
  /// axis, false if the reference continues.
  using Concerned = std::map<std::size_t, bool>;

  /// Returns the axes that must apply settings: the axes whose settings are in `changes`, and the axes that
  /// may have applied a former change that another axis refused (mark_uncertain()).
  Concerned concerned_by(const std::vector<config::Change>& changes) const;
  Prepared prepare(History history) const;

  std::filesystem::path file_;
  config::ReadFiles files_;
  std::vector<std::string> names_;
  History history_{{}};
  std::vector<config::Setting> settings_;
  Concerned uncertain_;
};

}  // namespace hystcan::app
