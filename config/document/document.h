// A TOML file, and the visitors that copy values between its tables and structs.
//
// Each struct has one `visit` (config/schema/schema.h) that names its keys, ranges, defaults and meanings. A
// Reader passed to it fills the struct, a Writer writes it, and a test compares the tables of
// docs/configuration/ with it. Unknown keys, missing keys, wrong types and values out of range are errors
// with line and column. The key of a duration has its unit in its name: _s, _ms or _us.
#pragma once

#include <toml++/toml.h>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/error.h"
#include "base/words.h"
#include "can/scheduler.h"
#include "config/document/setting.h"
#include "config/document/toml_text.h"

namespace hystcan::config {

/// The greatest size of a configuration in bytes, and of a model file, which may have long lists of weights.
inline constexpr std::size_t largest_configuration = 1'048'576;
inline constexpr std::size_t largest_model_file = 16 * largest_configuration;

class Document {
 public:
  /// Of a file that has this text, or will have it.
  Document(std::filesystem::path file, std::string_view text);
  /// Reads a regular file of at most `largest` bytes; the overrides replace its values.
  explicit Document(std::filesystem::path file, const std::vector<Setting>& overrides = {},
                    std::size_t largest = largest_configuration);

  const toml::table& root() const { return root_; }
  const std::filesystem::path& file() const { return file_; }
  /// Resolves a path of the file, which is relative to the file's own folder.
  std::filesystem::path resolve(const std::filesystem::path& path) const;

  /// The message begins with FILE:LINE:COLUMN, or with the key where an override stands.
  [[noreturn]] void fail(const toml::source_region& where, const std::string& what) const;
  /// Reports the place of the key with this path ("axis[1].amplifier_node"), or of the nearest table above
  /// it.
  [[noreturn]] void fail_at(std::string_view path, const std::string& what) const;

 private:
  /// The format is no key of the root: only the file has one.
  void take_format();
  void put(const Setting& setting);

  std::filesystem::path file_;
  toml::table root_;
};

double nanoseconds_per_unit(std::string_view key);

/// Fills structs from one table.
class Reader {
 public:
  Reader(const Document& document, const toml::table& table, std::string path)
      : document_(document), table_(table), path_(std::move(path)) {}

  template <class T>
  void required(std::string_view key, T& value, Range range = any, const About& = {}) {
    if (const toml::node* node = look_up(key)) read(*node, key, value, range);
  }
  template <class T>
  void optional(std::string_view key, T& value, Range range = any, const About& = {}) {
    known_.emplace(key);
    if (const toml::node* node = table_.get(key)) read(*node, key, value, range);
  }
  void choice(std::string_view key, std::string& value, std::span<const std::string_view> choices,
              const About& = {});
  /// One of the enum's words.
  template <HasWords Enum>
  void choice(std::string_view key, Enum& value, const About& = {}) {
    std::string word(word_of(value));
    choice(key, word, words(value));
    value = *parse_word<Enum>(word);
  }
  template <HasWords Enum>
  void optional_choice(std::string_view key, Enum& value, const About& = {}) {
    known_.emplace(key);
    if (table_.contains(key)) choice(key, value);
  }
  /// A list of some of the enum's words; optional.
  template <HasWords Enum>
  void choices(std::string_view key, std::vector<Enum>& values, const About& = {}) {
    std::vector<std::string> chosen;
    if (!read_choices(key, chosen, words(Enum{}))) return;
    values.clear();
    for (const std::string& word : chosen) values.push_back(*parse_word<Enum>(word));
  }
  /// Optional; may be empty.
  void numbers(std::string_view key, std::vector<double>& values, const About& = {});
  /// Optional; may be empty.
  void whole_numbers(std::string_view key, std::vector<std::int64_t>& values, const About& = {});
  /// A limit; another limit is in force if it is left out. `inf` means that there is no limit.
  void limit_or_inf(std::string_view key, double& value, double in_its_place, const About& = {});

  /// A sub-table that may be left out.
  template <class T, class Visit>
  void optional_table(std::string_view key, std::optional<T>& value, Visit visit) {
    known_.emplace(key);
    const toml::node* node = table_.get(key);
    if (node != nullptr && missing_.empty()) read_table(*node, join(key), value.emplace(), visit);
  }
  /// A sub-table that may be left out because all its keys have defaults.
  template <class T, class Visit>
  void section(std::string_view key, T& value, Visit visit) {
    known_.emplace(key);
    const toml::node* node = table_.get(key);
    if (node != nullptr && missing_.empty()) read_table(*node, join(key), value, visit);
  }
  /// A sub-table with its own struct: calls `visit(reader, value)`.
  template <class T, class Visit>
  void table(std::string_view key, T& value, Visit visit) {
    const toml::node* node = look_up(key);
    if (!missing_.empty()) return;  // the sub-table's keys may depend on the missing key
    read_table(*node, join(key), value, visit);
  }
  /// An array of at least one table.
  template <class T, class Visit>
  void list(std::string_view key, std::vector<T>& values, Visit visit) {
    const toml::node* node = look_up(key);
    if (!missing_.empty()) return;
    const toml::array* array = node->as_array();
    if (array == nullptr || array->empty())
      wrong_type(*node, key, "an array of tables, [[" + join(key) + "]]");
    values.clear();
    for (std::size_t i = 0; i < array->size(); ++i)
      read_table(*array->get(i), join(key) + "[" + std::to_string(i) + "]", values.emplace_back(), visit);
  }
  /// An array of tables that may be left out.
  template <class T, class Visit>
  void optional_list(std::string_view key, std::vector<T>& values, Visit visit) {
    known_.emplace(key);
    if (table_.contains(key)) list(key, values, visit);
  }
  /// Makes the alternative with this name.
  template <class Make>
  void alternative(Make make) {
    make();
  }

  /// Fails at an unknown key, then at a missing required key. The order matters because a misspelt key is
  /// both. Where a missing key is a choice, which may decide on the keys, only one that is close to a known
  /// one counts as unknown.
  void finish() const;

 private:
  template <class T, class Visit>
  void read_table(const toml::node& node, const std::string& path, T& value, Visit visit) {
    const toml::table* sub = node.as_table();
    if (sub == nullptr) wrong_type(node, path, "a table");
    Reader reader(document_, *sub, path);
    visit(reader, value);
    reader.finish();
  }

  template <class T>
  void read(const toml::node& node, std::string_view key, T& value, Range range) {
    if constexpr (std::is_same_v<T, bool>) {
      value = read_bool(node, key);
    } else if constexpr (std::is_integral_v<T>) {
      value =
          static_cast<T>(read_integer(node, key, range, static_cast<double>(std::numeric_limits<T>::max())));
    } else if constexpr (std::is_floating_point_v<T>) {
      value = read_number(node, key, range);
    } else if constexpr (std::is_same_v<T, can::Duration>) {
      value = read_duration(node, key, range);
    } else if constexpr (std::is_same_v<T, std::vector<double>>) {
      value = read_numbers(node, key, range);
    } else {
      value = read_string(node, key);
    }
  }

  /// False where the key is not there.
  bool read_choices(std::string_view key, std::vector<std::string>& values,
                    std::span<const std::string_view> choices);
  bool read_bool(const toml::node& node, std::string_view key) const;
  std::int64_t read_integer(const toml::node& node, std::string_view key, Range range, double type_max) const;
  double read_number(const toml::node& node, std::string_view key, Range range) const;
  /// Fails beyond a year, which no timer needs and a computation with times still has room for, and where
  /// less than a nanosecond would become zero.
  can::Duration read_duration(const toml::node& node, std::string_view key, Range range) const;
  std::vector<double> read_numbers(const toml::node& node, std::string_view key, Range range) const;
  std::string read_string(const toml::node& node, std::string_view key) const;

  /// The node of a required key; null if it is absent, and finish() then fails.
  const toml::node* look_up(std::string_view key);
  [[noreturn]] void wrong_type(const toml::node& node, std::string_view key,
                               const std::string& expected) const;
  std::string join(std::string_view key) const;

  const Document& document_;
  const toml::table& table_;
  std::string path_;
  std::set<std::string, std::less<>> known_;
  std::string missing_;        ///< the first required key that is absent
  bool lacks_choice_ = false;  ///< of the absent keys, one is a choice
};

/// Writes structs as TOML. A remark decides which keys are written, and what stands behind their values.
class Writer {
 public:
  enum class Layout : std::uint8_t {
    plain,    ///< `hystcan check`: each number with the fewest characters
    columns,  ///< a file: equals signs and comments below each other, numbers that are not whole have a point
    model,    ///< a model file: numbers of some digits, meanings as comments
    schema    ///< for the remark alone: also keys that are left out, and those of tables that are left out
  };
  /// `table`: in whose keys the struct's are, as path and header; empty: the file's.
  Writer(Layout layout, Remark remark, std::string table = {})
      : layout_(layout), remark_(std::move(remark)), header_(table), path_(std::move(table)) {}

  template <class T>
  void required(std::string_view key, const T& value, Range range = any, const About& about = {}) {
    line(key, text_of(key, value, about.digits), true, about, choices_of<T>(), range);
  }
  /// An infinite number and an empty text say that the key is left out. A key without a default of its own
  /// counts as required otherwise.
  template <class T>
  void optional(std::string_view key, const T& value, Range range = any, const About& about = {}) {
    bool is_left_out = false;
    if constexpr (std::is_floating_point_v<T>)
      is_left_out = !std::isfinite(value);
    else if constexpr (std::is_convertible_v<T, std::filesystem::path>)
      is_left_out = value.empty();
    if (!is_left_out || layout_ == Layout::schema)
      line(key, text_of(key, value), !about.otherwise.empty(), about, choices_of<T>(), range);
  }
  void choice(std::string_view key, const std::string& value, std::span<const std::string_view> choices,
              const About& about = {}) {
    line(key, text_of(key, value), true, about, choices);
  }
  template <HasWords Enum>
  void choice(std::string_view key, Enum value, const About& about = {}) {
    line(key, text_of(key, word_of(value)), true, about, choices_of<Enum>());
  }
  template <HasWords Enum>
  void optional_choice(std::string_view key, Enum value, const About& about = {}) {
    line(key, text_of(key, word_of(value)), false, about, choices_of<Enum>());
  }
  template <HasWords Enum>
  void choices(std::string_view key, const std::vector<Enum>& values, const About& about = {}) {
    std::vector<std::string_view> chosen;
    chosen.reserve(values.size());
    for (const Enum value : values) chosen.push_back(word_of(value));
    if (!chosen.empty()) line(key, list_of(chosen), false, about);
  }
  void whole_numbers(std::string_view key, const std::vector<std::int64_t>& values, const About& about = {});
  void numbers(std::string_view key, const std::vector<double>& values, const About& about = {}) {
    optional(key, values, any, about);
  }
  /// `in_its_place`: in force where it is left out; infinite: nothing. Shown as a comment, as it is no value
  /// of the key.
  void limit_or_inf(std::string_view key, double value, double in_its_place, const About& about = {});
  template <class T, class Visit>
  void table(std::string_view key, T& value, Visit visit) {
    enter(key, {}, [&](Writer& writer) { visit(writer, value); });
  }
  template <class T, class Visit>
  void section(std::string_view key, T& value, Visit visit) {
    table(key, value, visit);
  }
  template <class T, class Visit>
  void optional_table(std::string_view key, std::optional<T>& value, Visit visit) {
    if (value) return table(key, *value, visit);
    T left_out{};
    if (layout_ == Layout::schema) table(key, left_out, visit);
  }
  template <class T, class Visit>
  void list(std::string_view key, std::vector<T>& values, Visit visit) {
    for (std::size_t i = 0; i < values.size(); ++i)
      enter(key, "[" + std::to_string(i) + "]", [&](Writer& writer) { visit(writer, values[i]); });
  }
  template <class T, class Visit>
  void optional_list(std::string_view key, std::vector<T>& values, Visit visit) {
    if (layout_ == Layout::schema) line(key, {}, false);
    list(key, values, visit);
  }
  template <class Make>
  void alternative(Make) {}

  std::string text() const { return keys_ + tables_; }

 private:
  template <class T>
  std::string text_of(std::string_view key, const T& value, int digits = About{}.digits) const {
    if constexpr (std::is_same_v<T, bool>)
      return value ? "true" : "false";
    else if constexpr (std::is_same_v<T, can::Duration>)
      return number(static_cast<double>(value.count()) / nanoseconds_per_unit(key));
    else if constexpr (std::is_floating_point_v<T>)
      return number(value, digits);
    else if constexpr (std::is_integral_v<T>)
      return std::to_string(value);
    else if constexpr (std::is_same_v<T, std::vector<double>>)
      return list_of(value);
    else
      return toml_string(std::filesystem::path(value).string());
  }
  /// A table, or the element of a list with this index.
  void enter(std::string_view key, const std::string& index, const std::function<void(Writer&)>& body);
  template <class T>
  static std::span<const std::string_view> choices_of() {
    if constexpr (HasWords<T>) {
      static const auto& all = words(T{});
      return all;
    } else if constexpr (std::is_same_v<T, bool>) {
      static constexpr auto both = std::to_array<std::string_view>({"false", "true"});
      return both;
    } else {
      return {};
    }
  }
  void line(std::string_view key, const std::string& value, bool is_required, const About& about = {},
            std::span<const std::string_view> choices = {}, Range range = any);
  std::string number(double value, int digits = About{}.digits) const;
  std::string list_of(const std::vector<double>& values) const;
  static std::string list_of(const std::vector<std::string_view>& words);

  Layout layout_;
  Remark remark_;
  std::string header_;  ///< the table's name in TOML
  std::string path_;    ///< the table's name with indices
  std::string keys_;    ///< the text of the table's own keys
  std::string tables_;  ///< and that of the tables in it
};

}  // namespace hystcan::config
