// The configuration in force, flat: one setting for each key, and what has changed between two of them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/config.h"

namespace hystcan::config {

/// Every key in force, defaults too, in the order of `check`'s output. Throws Error.
std::vector<Setting> settings(const std::filesystem::path& file, const std::vector<Setting>& overrides = {});

/// What takes a change up.
enum class Effect : std::uint8_t {
  at_once,        ///< the running controller, between two cycles
  after_restart,  ///< the controller when it is started again
  on_twin,        ///< nothing in the controller
};
Effect effect_of(std::string_view path);

struct Change {
  std::string path;
  std::string from;  ///< as TOML; empty: was not there
  std::string to;    ///< as TOML; empty: is there no more
};
std::vector<Change> changes(const std::vector<Setting>& before, const std::vector<Setting>& after);

/// "axis[0].control.kp: 0.05 -> 0.08".
std::string describe(const Change& change);

}  // namespace hystcan::config
