// The configuration of a running controller: the settings in force, and the changes that a new version of the
// file, or a single setting, would cause. This class prepares changes and applies nothing. The caller applies
// all prepared changes, or none if one of them needs a restart, because the file was checked as a whole.
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
  /// The configuration at the start of the process. `files`: the cache with which it was loaded, so that a
  /// change does not read unchanged files again.
  LiveConfig(std::filesystem::path file, const config::Config& config, config::ReadFiles files = {});

  /// The overrides of the file: one element for the file alone, then one element after each single setting.
  /// The last element is in force.
  using History = std::vector<std::vector<config::Setting>>;

  struct Prepared {
    std::vector<config::Setting> settings;  ///< in force after this is applied
    History history;
    std::vector<config::Change> at_once{};
    std::vector<config::Change> after_restart{};
    /// Retune requests, one for each axis that the changes concern.
    std::vector<std::unique_ptr<controller::Request>> requests{};
  };
  /// Prepares the change to the present file; discards earlier single settings. Throws Error.
  Prepared reread() const;
  /// Prepares the change of one key in [axis.control], for example "kp" or "delays.resonance_Hz".
  Prepared with(std::string_view axis, std::string_view key, const std::string& toml_value) const;
  /// Prepares the undo of the last single setting. Throws Error if there is none since the file was read.
  Prepared without_the_last() const;
  /// Call this after `prepared` was applied.
  void accept(const Prepared& prepared);
  /// Call this if one axis refused `prepared` and another axis may have applied it. The next change then
  /// sends all settings to every axis that `prepared` concerns.
  void mark_uncertain(const Prepared& prepared);

  const std::filesystem::path& file() const { return file_; }
  const std::vector<config::Setting>& settings() const { return settings_; }
  /// Returns the settings of the present file, which is read again only if it changed. Throws Error.
  std::vector<config::Setting> settings_of_file() const { return config::settings(file_, {}, files_); }
  std::size_t single_settings() const { return history_.size() - 1; }
  const std::vector<std::string>& axis_names() const { return names_; }
  /// Throws Error if no axis has this name.
  std::size_t axis_index(std::string_view name) const;

 private:
  /// Index of each axis concerned; true if its reference restarts, false if it continues unchanged.
  using Concerned = std::map<std::size_t, bool>;

  /// Returns the axes that the changes concern, and the axes of mark_uncertain().
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
