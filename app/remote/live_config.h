// The configuration of a running controller: what is in force, and what a new version of the file, or a
// single setting, would change. Nothing is applied here; what is prepared is applied whole, or, where any of
// it needs a restart, not at all: the file was checked as a whole.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/config.h"
#include "config/schema/settings.h"
#include "controller/request_link.h"

namespace hystcan::app {

class LiveConfig {
 public:
  /// What the process was started with.
  LiveConfig(std::filesystem::path file, const config::Config& config);

  struct Prepared {
    std::vector<config::Setting> settings;  ///< in force once this is applied
    std::vector<config::Setting> overrides;
    std::vector<config::Change> at_once;
    std::vector<config::Change> after_restart;
    std::vector<std::unique_ptr<controller::Request>> requests;  ///< retune, one for each axis concerned
  };
  /// The file as it is now; single settings made before are forgotten. Throws config::Error, can::DbcError.
  Prepared reread() const;
  /// One setting of an axis's control in the place of what is in force: key "kp", "delays.resonance_Hz".
  Prepared with(std::string_view axis, std::string_view key, const std::string& toml_value) const;
  /// It has been applied.
  void accept(const Prepared& prepared);
  /// An axis has refused it, another one may have taken it up: both are told everything with the next
  /// version.
  void doubt(const Prepared& prepared);

  const std::filesystem::path& file() const { return file_; }
  const std::vector<std::string>& axis_names() const { return names_; }
  /// Throws config::Error where there is none of that name.
  std::size_t axis_index(std::string_view name) const;

 private:
  Prepared prepare(std::vector<config::Setting> overrides) const;

  std::filesystem::path file_;
  std::vector<std::string> names_;
  std::vector<config::Setting> overrides_;
  std::vector<config::Setting> settings_;
  std::map<std::size_t, bool> doubted_;  ///< axes, and whether their reference too
};

}  // namespace hystcan::app
