// Changes values in the text of a TOML file. Comments, order, spaces and line ends stay as they are.
//
//   set                 replaces the value where it stands. A key that is absent becomes a line below the
//                       last one of its table; a table that is absent becomes [a.table] below its parent's
//                       keys
//   set_comment         replaces the comment behind a value
//   comment_out         puts `# ` before each line of the key or table; it is absent then
//
// A path is that of a Setting: "axis[1].control.notch.depth". A value within an inline table is replaced;
// nothing is added to a table that has no header of its own, as {...} and dotted keys have none.
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
  /// Throws Error if the text is no TOML. Errors begin with `name`.
  TomlEdit(std::string text, std::string name);
  TomlEdit(TomlEdit&&) = default;  ///< not copied: a copy of toml++'s nodes does not know where they stand
  /// Reads a regular file of at most `largest` bytes.
  static TomlEdit of_file(const std::filesystem::path& file, std::size_t largest = largest_configuration);

  /// `value` is TOML, and the keys of the path need no quotes. Throws Error with the place where the text has
  /// no place for the key; nothing is changed then.
  void set(const std::string& path, const std::string& value);
  /// Does nothing if the key is absent. Throws Error where it stands in an inline table, if it is a table
  /// that has further tables, or a list of tables.
  void comment_out(const std::string& path);

  /// Replaces the comment behind the value. Does nothing if the key is absent or has none.
  void set_comment(const std::string& path, const std::string& comment);

  const std::string& text() const { return text_; }
  /// The text of the value at a path that exists: "{ kind = 'hold' }".
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
  /// Takes the text if it is TOML in which the path has this value; throws otherwise.
  void take(std::string text);

  std::string text_;
  std::string name_;
  toml::table root_;
};

}  // namespace hystcan::config
