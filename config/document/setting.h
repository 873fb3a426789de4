// One key of a configuration: its value, and what is said of it.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace hystcan::config {

/// A key by its path ("axis[0].control.kp") and its value, as TOML.
struct Setting {
  std::string path;
  std::string value;
};

/// The allowed range of a number.
struct Range {
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();
  bool lo_excluded = false;

  bool contains(double value) const { return (lo_excluded ? value > lo : value >= lo) && value <= hi; }
  std::string describe() const;
};
inline constexpr Range any{};
inline constexpr Range positive{.lo = 0.0, .lo_excluded = true};
inline constexpr Range not_negative{.lo = 0.0};

/// What is said of a key, in the tables of docs/configuration/*.md or behind its value in a model file.
struct About {
  std::string_view meaning{};
  std::string_view otherwise{};  ///< what holds where the key is left out and no default does: "of the model"
  int digits = 17;               ///< significant ones in a model file; 17 bring back the same bits
};

/// A key with what its struct's `visit` says of it.
struct Key : Setting {
  Range range{};
  std::string_view meaning{};
  std::span<const std::string_view> choices{};
};

/// What a Writer asks about each key: the comment behind it, which may be empty; nothing: the key is left
/// out. It asks about tables too, with an empty value.
using Remark = std::function<std::optional<std::string>(const Key& key, bool is_required)>;

}  // namespace hystcan::config
