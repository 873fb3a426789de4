// A TOML file, and the visitors that copy values between its tables and structs.
//
// Each struct has one `visit` (config/schema/schema.h) with its keys, ranges, defaults and descriptions. A
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
#include <memory>
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

/// Maximum sizes in bytes of a configuration, and of a model file, which may have long lists of weights.
inline constexpr std::size_t largest_configuration = 1'048'576;
inline constexpr std::size_t largest_model_file = 16 * largest_configuration;

class Document {
 public:
  /// Parses a text that is, or will be, the content of `file`.
  Document(std::filesystem::path file, std::string_view text);
  /// Reads a regular file of at most `largest` bytes.
  explicit Document(const std::filesystem::path& file, std::size_t largest = largest_configuration);
  /// Returns a copy in which the overrides set the values of their keys.
  Document with(const std::vector<Setting>& overrides) const;

  const toml::table& root() const { return *root_; }
  bool has(std::string_view path) const { return static_cast<bool>(root_->at_path(path)); }
  const std::filesystem::path& file() const { return file_; }
  /// Resolves a path in the file; it is relative to the file's own folder.
  std::filesystem::path resolve(const std::filesystem::path& path) const;

  /// Returns FILE:LINE:COLUMN, or the key if an override sets the value.
  Place place_of(const toml::source_region& where) const;
  /// Returns the place of the key with this path ("axis[1].amplifier_node"), or of the nearest table above
  /// it.
  Place place_at(std::string_view path) const;
  [[noreturn]] void fail_at(std::string_view path, const std::string& what) const {
    throw Error(place_at(path), what);
  }

 private:
  void put(const Setting& setting, toml::table& root);

  std::filesystem::path file_;
  std::shared_ptr<const toml::table> read_;  ///< the table as parsed; its nodes have source places, which a
                                             ///< copy loses
  std::shared_ptr<const toml::table> root_;  ///< read_, or a copy with other values
  std::vector<std::string> overridden_{};    ///< paths of the overridden keys
};

double nanoseconds_per_unit(std::string_view key);

/// A list of words of one enumeration.
template <class T>
concept ListOfWords = requires {
  typename T::value_type;
}
&&HasWords<typename T::value_type>;

/// Fills structs from one table.
class Reader {
 public:
  Reader(const Document& document, const toml::table& table, std::string path)
      : document_(document), table_(table), path_(std::move(path)) {}

  template <class T>
  void required(std::string_view key, T& value, Range range = any, const About& = {}) {
    lacks_choice_ |= HasWords<T> && !table_.contains(key);
    if (const toml::node* node = look_up(key)) read(*node, key, value, range);
  }
  /// Reads an optional key; a list may be empty.
  template <class T>
  void optional(std::string_view key, T& value, Range range = any, const About& = {}) {
    known_.emplace(key);
    if (const toml::node* node = table_.get(key)) read(*node, key, value, range, 0);
  }
  void choice(std::string_view key, std::string& value, std::span<const std::string_view> choices,
              const About& = {});
  /// Reads a limit; the value `inf` means no limit. If the key is missing, the limit `in_its_place` applies.
  void limit_or_inf(std::string_view key, double& value, double in_its_place, const About& = {});

  /// Reads a sub-table that may be missing.
  template <class T, class Visit>
  void optional_table(std::string_view key, std::optional<T>& value, Visit visit) {
    known_.emplace(key);
    if (table_.contains(key)) table(key, value.emplace(), visit);
  }
  /// Reads a sub-table that may be missing because all its keys have defaults.
  template <class T, class Visit>
  void section(std::string_view key, T& value, Visit visit) {
    known_.emplace(key);
    if (table_.contains(key)) table(key, value, visit);
  }
  /// Reads a sub-table with its own struct: calls `visit(reader, value)`.
  template <class T, class Visit>
  void table(std::string_view key, T& value, Visit visit) {
    const toml::node* node = look_up(key);
    if (!missing_.empty()) return;  // the sub-table's keys may depend on the missing key
    read_table(*node, join(key), value, visit);
  }
  /// Reads an array of at least one table.
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
  /// Reads an array of tables that may be missing.
  template <class T, class Visit>
  void optional_list(std::string_view key, std::vector<T>& values, Visit visit) {
    known_.emplace(key);
    if (table_.contains(key)) list(key, values, visit);
  }
  /// Creates the alternative that a choice selected.
  template <class Make>
  void alternative(Make make) {
    make();
  }
  void takes_effect(Effect) {}

  /// Fails at the first unknown key, then at the first missing required key: a misspelt key is both, and the
  /// error should quote it. If a missing key is a choice, which decides which keys exist, only a key that
  /// resembles a known one counts as unknown.
  void finish() const;

 private:
  using Index = std::optional<std::size_t>;

  template <class T, class Visit>
  void read_table(const toml::node& node, const std::string& path, T& value, Visit visit) {
    Reader reader(document_, table_at(node, path), path);
    visit(reader, value);
    reader.finish();
  }

  template <class T>
  void read(const toml::node& node, std::string_view key, T& value, Range range, std::size_t /*least*/ = 1) {
    if constexpr (std::is_same_v<T, bool>) {
      value = read_bool(node, key);
    } else if constexpr (std::is_integral_v<T>) {
      value =
          static_cast<T>(read_integer(node, key, range, static_cast<double>(std::numeric_limits<T>::max())));
    } else if constexpr (std::is_floating_point_v<T>) {
      value = read_number(node, key, range);
    } else if constexpr (std::is_same_v<T, can::Duration>) {
      value = read_duration(node, key, range);
    } else if constexpr (HasWords<T>) {
      value = *parse_word<T>(read_word(node, key, words(value)));
    } else {
      value = read_string(node, key);
    }
  }
  template <class Element>
  void read(const toml::node& node, std::string_view key, std::vector<Element>& values, Range range,
            std::size_t least = 1) {
    constexpr bool has_words = HasWords<Element>, is_whole = std::is_integral_v<Element>;
    const toml::array* array = node.as_array();
    if (array == nullptr)
      wrong_type(node, key,
                 has_words  ? "an array of words"
                 : is_whole ? "an array of whole numbers"
                            : "an array of numbers");
    if (array->size() < least) fail(key, "is empty, expected at least one number");
    values.clear();
    for (const toml::node& element : *array)
      if constexpr (has_words)
        values.push_back(*parse_word<Element>(read_word(element, key, words(Element{}), values.size())));
      else if constexpr (is_whole)
        values.push_back(read_whole_number(element, key, values.size()));
      else
        values.push_back(read_number(element, key, range, values.size()));
  }

  const toml::table& table_at(const toml::node& node, const std::string& path) const;
  bool read_bool(const toml::node& node, std::string_view key) const;
  std::int64_t read_whole_number(const toml::node& node, std::string_view key, Index index = {}) const;
  std::int64_t read_integer(const toml::node& node, std::string_view key, Range range, double type_max) const;
  double read_number(const toml::node& node, std::string_view key, Range range, Index index = {}) const;
  /// Fails if the duration is longer than a year, which time computations can still represent, or if it is
  /// shorter than a nanosecond and would become zero.
  can::Duration read_duration(const toml::node& node, std::string_view key, Range range) const;
  std::string read_string(const toml::node& node, std::string_view key, Index index = {}) const;
  std::string read_word(const toml::node& node, std::string_view key,
                        std::span<const std::string_view> choices, Index index = {}) const;

  /// Returns the node of a required key; null if the key is missing (finish() then fails).
  const toml::node* look_up(std::string_view key);
  /// Throws "KEY what", at the key or at an element of its list.
  [[noreturn]] void fail(std::string_view key, const std::string& what, Index index = {}) const;
  [[noreturn]] void wrong_type(const toml::node& node, std::string_view key, const std::string& expected,
                               Index index = {}) const;
  std::string join(std::string_view key) const;

  const Document& document_;
  const toml::table& table_;
  std::string path_;
  std::set<std::string, std::less<>> known_;
  std::string missing_;        ///< the first required key that is missing
  bool lacks_choice_ = false;  ///< one of the missing keys is a choice
};

/// Writes structs as TOML. A Remark decides which keys are written, and the comment after each value.
class Writer {
 public:
  enum class Layout : std::uint8_t {
    plain,    ///< `hystcan check`: each number with the fewest characters
    columns,  ///< a file: aligned equals signs and comments; fractions have a decimal point
    model,    ///< a model file: numbers with a limited number of digits, descriptions as comments
    schema    ///< only calls the remark, without values; includes keys and tables that are left out
  };
  /// `table`: the table of the struct's keys, as path and header; empty: the root of the file.
  Writer(Layout layout, Remark remark, std::string table = {})
      : layout_(layout), remark_(std::move(remark)), header_(table), path_(std::move(table)) {}

  template <class T>
  void required(std::string_view key, const T& value, Range range = any, const About& about = {}) {
    line(key, value, text_of(key, value, about.digits), true, about, choices_of<T>(), range);
  }
  /// Omits an infinite number, an empty text or an empty list of words. A key without a default counts as
  /// required, unless it is a word.
  template <class T>
  void optional(std::string_view key, const T& value, Range range = any, const About& about = {}) {
    bool is_left_out = false;
    if constexpr (std::is_floating_point_v<T>)
      is_left_out = !std::isfinite(value);
    else if constexpr (std::is_convertible_v<T, std::filesystem::path> || ListOfWords<T>)
      is_left_out = value.empty();
    const bool is_required = !about.otherwise.empty() && !HasWords<T> && !ListOfWords<T>;
    if (!is_left_out || layout_ == Layout::schema)
      line(key, value, text_of(key, value), is_required, about, choices_of<T>(), range);
  }
  void choice(std::string_view key, const std::string& value, std::span<const std::string_view> choices,
              const About& about = {}) {
    line(key, value, text_of(key, value), true, about, choices);
  }
  /// `in_its_place`: the limit in force if the key is missing; infinite: none. It is written as a comment,
  /// because it is not the key's value.
  void limit_or_inf(std::string_view key, const double& value, double in_its_place, const About& about = {});
  template <class T, class Visit>
  void table(std::string_view key, T& value, Visit visit) {
    enter(key, {}, value, [&](Writer& writer) { visit(writer, value); });
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
      enter(key, "[" + std::to_string(i) + "]", values[i], [&](Writer& writer) { visit(writer, values[i]); });
  }
  template <class T, class Visit>
  void optional_list(std::string_view key, std::vector<T>& values, Visit visit) {
    if (layout_ == Layout::schema) line(key, values, {}, false);
    list(key, values, visit);
  }
  template <class Make>
  void alternative(Make) {}
  /// Sets the effect of all following keys in this table and its sub-tables that have no effect of their own.
  void takes_effect(Effect effect) { effect_ = effect; }

  std::string text() const { return keys_ + tables_; }

 private:
  template <class T>
  std::string text_of(std::string_view key, const T& value, int digits = About{}.digits) const {
    if (layout_ == Layout::schema) return {};
    if constexpr (std::is_same_v<T, bool>)
      return value ? "true" : "false";
    else if constexpr (std::is_same_v<T, can::Duration>)
      return number(static_cast<double>(value.count()) / nanoseconds_per_unit(key));
    else if constexpr (std::is_floating_point_v<T>)
      return number(value, digits);
    else if constexpr (std::is_integral_v<T>)
      return std::to_string(value);
    else if constexpr (HasWords<T>)
      return toml_string(word_of(value));
    else if constexpr (std::is_same_v<T, std::vector<double>> || std::is_same_v<T, std::vector<std::int64_t>>)
      return list_of(value);
    else if constexpr (ListOfWords<T>)
      return list_of([&] {
        std::vector<std::string_view> chosen;
        chosen.reserve(value.size());
        for (const auto word : value) chosen.push_back(word_of(word));
        return chosen;
      }());
    else
      return toml_string(std::filesystem::path(value).string());
  }
  /// Writes a table, or the element of a list with this index.
  void enter(std::string_view key, const std::string& index, const Member& member,
             const std::function<void(Writer&)>& body);
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
  void line(std::string_view key, const Member& member, const std::string& value, bool is_required,
            const About& about = {}, std::span<const std::string_view> choices = {}, Range range = any);
  std::string number(double value, int digits = About{}.digits) const;
  std::string list_of(const std::vector<double>& values) const;
  static std::string list_of(const std::vector<std::int64_t>& values);
  static std::string list_of(const std::vector<std::string_view>& words);

  Layout layout_;
  Remark remark_;
  std::string header_;  ///< TOML name of the table
  std::string path_;    ///< TOML name of the table, with indices
  std::string keys_;    ///< text of the table's own keys
  std::string tables_;  ///< text of the sub-tables
  Effect effect_ = Effect::after_restart;
};

}  // namespace hystcan::config
