// The configuration in force as a flat list with one setting per key, and the changes between two lists.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/config.h"

namespace hystcan::config {

/// All keys in force, including defaults, in the order of `check`'s output. Throws Error.
std::vector<Setting> settings(const std::filesystem::path& file, const std::vector<Setting>& overrides = {});

/// When a change takes effect.
enum class Effect : std::uint8_t {
  at_once,        ///< in the running controller, between two cycles
  after_restart,  ///< when the controller is started again
  on_twin,        ///< only in the twin
};
Effect effect_of(std::string_view path);

struct Change {
  std::string path;
  std::string from;  ///< as TOML; empty if the key is new
  std::string to;    ///< as TOML; empty if the key is gone
};
std::vector<Change> changes(const std::vector<Setting>& before, const std::vector<Setting>& after);

/// "axis[0].control.kp: 0.05 -> 0.08".
std::string describe(const Change& change);

}  // namespace hystcan::config
