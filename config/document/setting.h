// One key of a configuration and its value.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace hystcan::config {

/// A key by its path ("axis[0].control.kp") and its value, as TOML.
struct Setting {
  std::string path;
  std::string value;
};

/// What a Writer asks about each key: the comment behind it, which may be empty; nothing: the key is left
/// out. It asks about tables too, with an empty value.
using Remark = std::function<std::optional<std::string>(const Setting& key, bool is_required)>;

}  // namespace hystcan::config
