// A TOML file, and the visitors that copy values between its tables and structs.
//
// Each struct of the configuration has one function `visit` (config/schema/schema.h), which lists the
// struct's keys with ranges, defaults and descriptions. visit() with a Reader fills the struct from a table;
// visit() with a Writer writes the struct as text. A test compares the tables of docs/configuration/ with
// these lists. Unknown keys, missing keys, wrong types and values out of range are errors with line and
// column. The key of a duration ends with the unit: _s, _ms or _us.
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

/// Maximum sizes of a configuration file and of a model file, in bytes. A model file may have long lists of
/// weights, so its maximum is larger.
inline constexpr std::size_t largest_configuration = 1'048'576;
inline constexpr std::size_t largest_model_file = 16 * largest_configuration;

class Document {
 public:
  /// Parses `text`. `file` is the name in error messages and the base of relative paths; it is not read.
  Document(std::filesystem::path file, std::string_view text);
  /// Reads and parses `file`, a regular file of at most `largest` bytes.
  explicit Document(const std::filesystem::path& file, std::size_t largest = largest_configuration);
  /// Returns a copy of the document in which the keys of `overrides` have the values of `overrides`.
  Document with(const std::vector<Setting>& overrides) const;

  const toml::table& root() const { return *root_; }
  bool has(std::string_view path) const { return static_cast<bool>(root_->at_path(path)); }
  const std::filesystem::path& file() const { return file_; }
  /// Returns the full path for a path that is written in the document: it is relative to the document's
  /// folder.
  std::filesystem::path resolve(const std::filesystem::path& path) const;

  /// Returns the place of a value, for error messages: FILE:LINE:COLUMN, or the key if an override sets the
  /// value.
  Place place_of(const toml::source_region& where) const;
  /// Returns the place of the key with this path, for example "axis[1].amplifier_node". If the key is
  /// missing, returns the place of the innermost existing table on the path.
  Place place_at(std::string_view path) const;
  [[noreturn]] void fail_at(std::string_view path, const std::string& what) const {
    throw Error(place_at(path), what);
  }

 private:
  void put(const Setting& setting, toml::table& root);

  std::filesystem::path file_;
  std::shared_ptr<const toml::table> read_;  ///< the parsed file; its nodes have their line and column, which
                                             ///< a copy would lose
  std::shared_ptr<const toml::table> root_;  ///< read_, or a copy of it with overridden values
  std::vector<std::string> overridden_{};    ///< paths of the overridden keys
};

double nanoseconds_per_unit(std::string_view key);

/// A list whose elements are enumerators; in TOML it is a list of their words.
template <class T>
concept ListOfWords = requires {
  typename T::value_type;
}
&&HasWords<typename T::value_type>;

/// The visitor that fills a struct from a TOML table. Each function reads one key into one member.
class Reader {
 public:
  Reader(const Document& document, const toml::table& table, std::string path)
      : document_(document), table_(table), path_(std::move(path)) {}

  template <class T>
  void required(std::string_view key, T& value, Range range = any, const About& = {}) {
    lacks_choice_ |= HasWords<T> && !table_.contains(key);
    if (const toml::node* node = look_up(key)) read(*node, key, value, range);
  }
  /// Reads a key that may be missing. If the key is missing, `value` does not change. A list may be empty.
  template <class T>
  void optional(std::string_view key, T& value, Range range = any, const About& = {}) {
    known_.emplace(key);
    if (const toml::node* node = table_.get(key)) read(*node, key, value, range, 0);
  }
  void choice(std::string_view key, std::string& value, std::span<const std::string_view> choices,
              const About& = {});
  /// Reads a limit. If the key is missing or has the value `inf`, `value` does not change. Only the Writer
  /// uses `in_its_place`.
  void limit_or_inf(std::string_view key, double& value, double in_its_place, const About& = {});

  /// Reads a sub-table that may be missing. If the sub-table is missing, `value` does not change.
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
  /// Reads a required sub-table into the struct `value`: calls `visit` with a Reader of the sub-table.
  template <class T, class Visit>
  void table(std::string_view key, T& value, Visit visit) {
    const toml::node* node = look_up(key);
    if (!missing_.empty()) return;  // the keys of the sub-table may depend on a required key that is missing
    read_table(*node, join(key), value, visit);
  }
  /// Reads a required array of tables, which must have at least one table.
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
  /// Only calls `make`; Writer::alternative() does not call it. The keys of some tables depend on their key
  /// `kind`, for example in a segment of the reference. After `kind` was read from the file, `make` replaces
  /// the object by a new one of this kind, so that its other keys can be read.
  template <class Make>
  void alternative(Make make) {
    make();
  }
  void takes_effect(Effect) {}

  /// Throws Error if the table has an unknown key, or if a required key is missing. Unknown keys are checked
  /// first: if a required key is misspelt, the error should quote the misspelt key. A choice, for example
  /// the key `kind`, decides which other keys exist. So if a choice is missing, an unknown key is an error
  /// only if it resembles a known key and is probably misspelt.
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
  /// Reads a duration in the unit of its key. Throws Error if the duration is longer than a year, the maximum
  /// for time computations, or if it is shorter than a nanosecond and would become zero.
  can::Duration read_duration(const toml::node& node, std::string_view key, Range range) const;
  std::string read_string(const toml::node& node, std::string_view key, Index index = {}) const;
  std::string read_word(const toml::node& node, std::string_view key,
                        std::span<const std::string_view> choices, Index index = {}) const;

  /// Returns the TOML node of a required key. Returns null if the key is missing; finish(), which is called
  /// after the last key, then throws Error.
  const toml::node* look_up(std::string_view key);
  /// Throws Error with the message "KEY what" and the place of the key. With `index`, the place is the
  /// element of the key's list.
  [[noreturn]] void fail(std::string_view key, const std::string& what, Index index = {}) const;
  [[noreturn]] void wrong_type(const toml::node& node, std::string_view key, const std::string& expected,
                               Index index = {}) const;
  std::string join(std::string_view key) const;

  const Document& document_;
  const toml::table& table_;
  std::string path_;
  std::set<std::string, std::less<>> known_;
  std::string missing_;        ///< the first required key that is missing
  bool lacks_choice_ = false;  ///< true if a key is missing that decides which other keys exist, such as
                               ///< `kind`
};

/// The visitor that writes a struct as TOML. For each key, it calls a function, the Remark (setting.h). The
/// Remark decides whether the key is written, and returns the comment that follows the value.
class Writer {
 public:
  enum class Layout : std::uint8_t {
    plain,    ///< layout of `hystcan check`: each number has the fewest characters
    columns,  ///< layout of a file: equals signs and comments are aligned; floating-point numbers have a
              ///< decimal point
    model,    ///< layout of a model file: numbers have limited digits, descriptions are comments
    schema    ///< calls the Remark (setting.h) for every key and table, even if another layout would omit it
  };
  /// `table` is the TOML name of the table that contains the struct's keys; empty for the root of the file.
  Writer(Layout layout, Remark remark, std::string table = {})
      : layout_(layout), remark_(std::move(remark)), header_(table), path_(std::move(table)) {}

  template <class T>
  void required(std::string_view key, const T& value, Range range = any, const About& about = {}) {
    line(key, value, text_of(key, value, about.digits), true, about, choices_of<T>(), range);
  }
  /// Writes an optional key. Omits an infinite number, an empty text or an empty list of words. If
  /// `about.otherwise` is set, the default of the key is not the initial value of the member. The Remark then
  /// receives is_required = true, so that it does not omit a key with the initial value. Exception: words and
  /// lists of words are never required.
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
  /// Writes a limit. If the key is missing, `in_its_place` is the default, which applies to transitions only.
  /// If the key is present, `in_its_place` is infinite. The layout `plain` writes the default as a comment,
  /// because it is not the value of the key. Other layouts omit a missing key.
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
  /// Sets when a change of the following keys takes effect, in this table and its sub-tables. A key with
  /// About::effect has its own effect.
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
  /// Writes a table. For the element of a list of tables, `index` is its index ("[0]"); otherwise empty.
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
  std::string header_;  ///< TOML name of the table, without indices: "axis.control"
  std::string path_;    ///< TOML name of the table, with indices: "axis[1].control"
  std::string keys_;    ///< text of the table's own keys
  std::string tables_;  ///< text of the table's sub-tables
  Effect effect_ = Effect::after_restart;
};

}  // namespace hystcan::config
