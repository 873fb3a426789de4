// Changes values in the text of a TOML file. The rest of the text does not change: comments, order, spaces,
// line ends.
//
//   set                 replaces a value. If the key is missing, adds a line below the last key of its table.
//                       If the table is missing, adds a header [a.table] below the keys of the parent table
//   set_comment         replaces the comment after a value
//   comment_out         puts `# ` before each line of a key or table; the key or table is then missing
//
// A path has the form of Setting::path, for example "axis[1].control.notch.depth". set() can replace a value
// in an inline table {...}. It adds no key to an inline table or to a table of dotted keys, which have no
// header.
#pragma once

#include <toml++/toml.h>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/document/document.h"

namespace hystcan::config {

class TomlEdit {
 public:
  /// Throws Error if `text` is not valid TOML. `name` is the name of the text in error messages.
  TomlEdit(std::string text, std::string name);
  TomlEdit(TomlEdit&&) = default;  ///< movable only: a copy of toml++'s nodes would lose lines and columns
  /// Reads `file`, a regular file of at most `largest` bytes.
  static TomlEdit of_file(const std::filesystem::path& file, std::size_t largest = largest_configuration);

  /// Sets the key at `path` to `value`, a TOML text. The keys of the path must not need quotes. If the key
  /// can't be set or added, throws Error with the place of the problem and changes nothing.
  void set(const std::string& path, const std::string& value);
  /// Puts `# ` before each line of the key or table at `path`. Does nothing if the key is missing. Throws
  /// Error if the key is in a list or an inline table, is a table with sub-tables or dotted keys, or is a
  /// list of tables.
  void comment_out(const std::string& path);

  /// Replaces the comment after the value at `path`. Does nothing if the key or its comment is missing.
  void set_comment(const std::string& path, const std::string& comment);

  const std::string& text() const { return text_; }
  /// Returns the value at an existing path as it is written in the file, for example "{ kind = 'hold' }".
  std::string text_of(const std::string& path) const;

 private:
  struct Place;

  [[noreturn]] void fail(const toml::source_region& where, const std::string& what) const;
  Place find(const std::string& path) const;
  bool has_header(const toml::node& node) const;
  std::size_t offset_of(const toml::source_position& position) const;
  std::size_t line_start(std::size_t line) const;
  std::string_view line_at(std::size_t line) const;

  void replace_value(const toml::source_region& at, const std::string& value);
  void insert_below(std::size_t line, const std::vector<std::string>& lines);
  /// Replaces the whole text by `text`. Throws Error and changes nothing if `text` is not valid TOML.
  void take(std::string text);

  std::string text_;
  std::string name_;
  toml::table root_;
};

}  // namespace hystcan::config
