// One key of a configuration: its value and its description.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <typeindex>

namespace hystcan::config {

/// How a changed key takes effect.
enum class Effect : std::uint8_t {
  after_restart,  ///< when the controller restarts
  at_once,        ///< in the running controller, between two cycles
  at_next_start,  ///< in the running controller, at the next start of the axis
  new_reference,  ///< in the running controller; the reference restarts
  on_nodes        ///< when the twin or the node restarts
};
constexpr bool is_taken_over(Effect effect) {
  return effect != Effect::after_restart && effect != Effect::on_nodes;
}

/// A key: its path ("axis[0].control.kp") and its value as TOML.
struct Setting {
  std::string path;
  std::string value;
  Effect effect = Effect::after_restart;  ///< set if the key is from a `visit`
};

/// Returns true for the table's or list's own path and for the keys in it.
bool is_within(std::string_view path, std::string_view table);

/// The allowed range of a number.
struct Range {
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();
  bool lo_excluded = false;
  bool either_sign = false;  ///< the range applies to the magnitude

  bool contains(double number) const {
    const double value = either_sign ? std::abs(number) : number;
    return (lo_excluded ? value > lo : value >= lo) && value <= hi;
  }
  std::string describe() const;
};
inline constexpr Range any{};
inline constexpr Range positive{.lo = 0.0, .lo_excluded = true};
inline constexpr Range not_negative{.lo = 0.0};

/// Returns the unit at the end of a key or of its path, as written in text: "um/s^2", "%"; empty if none.
std::string unit_of(std::string_view key);

/// The description of a key, for the tables of docs/configuration/*.md and the comments of a model file.
struct About {
  std::string_view meaning{};
  std::string_view otherwise{};  ///< value in force if the key is missing and has no default: "of the model"
  std::optional<Effect> effect{};  ///< nullopt: the effect of its table
  int digits = 17;                 ///< significant digits in a model file; 17 restore the same bits
};

/// Identifies a member in a `visit`: its address and its type. The address alone does not suffice: the first
/// member of a struct has the address of the struct.
struct Member {
  Member() = default;
  template <class T>
  Member(const T& value) : place(&value), type(typeid(T)) {}
  bool operator==(const Member&) const = default;

  const void* place = nullptr;
  std::type_index type = typeid(void);
};

/// A key or a table with its description from the struct's `visit`. The default of a key is the initial value
/// of its member.
struct Key : Setting {
  Range range{};
  std::string_view meaning{};
  std::span<const std::string_view> choices{};
  Member member{};
  bool is_table = false;

  std::string unit() const { return unit_of(path); }
};

/// Called by a Writer for each key and, with an empty value, for each table. Returns the comment after the
/// value, which may be empty; nullopt omits the key.
using Remark = std::function<std::optional<std::string>(const Key& key, bool is_required)>;

}  // namespace hystcan::config
