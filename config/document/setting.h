// A key of a configuration: its value and its description.
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

/// The time at which a changed key takes effect.
enum class Effect : std::uint8_t {
  after_restart,  ///< the change takes effect when the controller restarts
  at_once,        ///< the change takes effect in the running controller, between two cycles
  at_next_start,  ///< the change takes effect in the running controller, at the next start of the axis
  new_reference,  ///< the change takes effect in the running controller, and the reference restarts
  on_nodes        ///< the change takes effect when the twin or the node restarts
};
constexpr bool is_taken_over(Effect effect) {
  return effect != Effect::after_restart && effect != Effect::on_nodes;
}

/// A key of a configuration: its path ("axis[0].control.kp") and its value as TOML text.
struct Setting {
  std::string path;
  std::string value;
  Effect effect = Effect::after_restart;  ///< time at which a change of the key takes effect; only valid if
                                          ///< a `visit` function created this object
};

/// Returns true if `path` is the path of `table` itself or of a key in it. `table` may also be a list.
bool is_within(std::string_view path, std::string_view table);

/// The allowed range of a number.
struct Range {
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();
  bool lo_excluded = false;
  bool either_sign = false;  ///< true: the range applies to the magnitude of the number

  bool contains(double number) const {
    const double value = either_sign ? std::abs(number) : number;
    return (lo_excluded ? value > lo : value >= lo) && value <= hi;
  }
  std::string describe() const;
};
inline constexpr Range any{};
inline constexpr Range positive{.lo = 0.0, .lo_excluded = true};
inline constexpr Range not_negative{.lo = 0.0};

/// Returns the unit in the name of a key, as written in text. Examples: "um/s^2" for `slew_um_per_s2`, "%"
/// for `gain_error_percent`. Returns an empty string if the name has no unit. `key` may have a path before
/// the name.
std::string unit_of(std::string_view key);

/// The description of a key, for the tables of docs/configuration/*.md and the comments of a model file.
struct About {
  std::string_view meaning{};
  std::string_view otherwise{};    ///< text in place of a default that is not a fixed value: "of the model"
  std::optional<Effect> effect{};  ///< when a change takes effect; nullopt: as for the key's table
  int digits = 17;                 ///< significant digits in a model file; 17 digits restore the same double
};

/// Identifies a member of a configuration struct by its address and its type. The address alone is not
/// enough, because the first member of a struct has the address of the struct.
struct Member {
  Member() = default;
  template <class T>
  Member(const T& value) : place(&value), type(typeid(T)) {}
  bool operator==(const Member&) const = default;

  const void* place = nullptr;
  std::type_index type = typeid(void);
};

/// A key or a table with its description, as the struct's `visit` function lists it. The default of a key is
/// not stored here: it is the initial value of the member.
struct Key : Setting {
  Range range{};
  std::string_view meaning{};
  std::span<const std::string_view> choices{};
  Member member{};
  bool is_table = false;

  std::string unit() const { return unit_of(path); }
};

/// A function that a Writer calls for each key and for each table (a table has an empty value). It returns
/// the comment to write after the value, which may be empty. If it returns nullopt, the Writer omits the key.
using Remark = std::function<std::optional<std::string>(const Key& key, bool is_required)>;

}  // namespace hystcan::config
