// One key of a configuration: its value, and what is said of it.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <typeindex>

namespace hystcan::config {

/// What takes over a change of a key, and what that restarts.
enum class Effect : std::uint8_t {
  after_restart,  ///< the controller, when it is started again
  at_once,        ///< the running controller, between two cycles
  at_next_start,  ///< the same, for the next start of the axis
  new_reference,  ///< the running controller, whose reference begins again
  on_nodes        ///< the twin or the node, when it is started again
};
constexpr bool is_taken_over(Effect effect) {
  return effect != Effect::after_restart && effect != Effect::on_nodes;
}

/// A key by its path ("axis[0].control.kp") and its value, as TOML.
struct Setting {
  std::string path;
  std::string value;
  Effect effect = Effect::after_restart;  ///< of a key from a `visit`
};

/// True for the path itself and for the keys of its table or list.
bool is_within(std::string_view path, std::string_view table);

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

/// The unit that a key, or its path, ends with, as it is written: "um/s^2", "%"; empty where it has none.
std::string unit_of(std::string_view key);

/// What is said of a key, in the tables of docs/configuration/*.md or behind its value in a model file.
struct About {
  std::string_view meaning{};
  std::string_view otherwise{};  ///< what holds where the key is left out and no default does: "of the model"
  std::optional<Effect> effect{};  ///< none: that of its table
  int digits = 17;                 ///< significant ones in a model file; 17 bring back the same bits
};

/// A member that a `visit` names: its place, and its type, because the first member of a struct has the place
/// of the struct.
struct Member {
  Member() = default;
  template <class T>
  Member(const T& value) : place(&value), type(typeid(T)) {}
  bool operator==(const Member&) const = default;

  const void* place = nullptr;
  std::type_index type = typeid(void);
};

/// A key, or a table, with what its struct's `visit` says of it. Its default is what its member begins with.
struct Key : Setting {
  Range range{};
  std::string_view meaning{};
  std::span<const std::string_view> choices{};
  Member member{};
  bool is_table = false;

  std::string unit() const { return unit_of(path); }
};

/// What a Writer asks about each key: the comment behind it, which may be empty; nothing: the key is left
/// out. It asks about tables too, with an empty value.
using Remark = std::function<std::optional<std::string>(const Key& key, bool is_required)>;

}  // namespace hystcan::config
