// Changes values in the text of a TOML file. Comments, order, spaces and line ends are unchanged.
//
//   set                 replaces the value in its place. A missing key becomes a line below the last key of
//                       its table; a missing table becomes [a.table] below its parent's keys
//   set_comment         replaces the comment after a value
//   comment_out         puts `# ` before each line of the key or table, which is then missing
//
// Paths have the form of Setting::path: "axis[1].control.notch.depth". A value in an inline table is
// replaced; nothing is added to a table without a header of its own ({...} and dotted keys).
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
  /// Throws Error if the text is not valid TOML. Error messages begin with `name`.
  TomlEdit(std::string text, std::string name);
  TomlEdit(TomlEdit&&) = default;  ///< not copyable: a copy of toml++'s nodes loses their source places
  /// Reads a regular file of at most `largest` bytes.
  static TomlEdit of_file(const std::filesystem::path& file, std::size_t largest = largest_configuration);

  /// Sets the value, which is TOML, at the path, whose keys must not need quotes. If the text can't take the
  /// key, throws Error with the place of the obstacle and changes nothing.
  void set(const std::string& path, const std::string& value);
  /// Does nothing if the key is missing. Throws Error if the key is in an inline table, is a table with
  /// sub-tables, or is a list of tables.
  void comment_out(const std::string& path);

  /// Replaces the comment after the value. Does nothing if the key or its comment is missing.
  void set_comment(const std::string& path, const std::string& comment);

  const std::string& text() const { return text_; }
  /// Returns the text of the value at an existing path: "{ kind = 'hold' }".
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
  /// Replaces the text if it is valid TOML in which the path has this value; throws otherwise.
  void take(std::string text);

  std::string text_;
  std::string name_;
  toml::table root_;
};

}  // namespace hystcan::config
