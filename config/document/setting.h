// One key of a configuration and its value.
#pragma once

#include <string>

namespace hystcan::config {

/// A key by its path ("axis[0].control.kp") and its value, as TOML.
struct Setting {
  std::string path;
  std::string value;
};

}  // namespace hystcan::config
