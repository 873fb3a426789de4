#include "config/document/toml_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <utility>

#include "base/error.h"
#include "base/input_file.h"
#include "base/text.h"
#include "config/document/toml_text.h"

namespace hystcan::config {
namespace {

/// Splits a path into keys and indices: "a[1].b" into "a", "[1]" and "b".
std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts{""};
  for (const char c : path) {
    if (c == '.' || c == '[') parts.emplace_back();
    if (c != '.') parts.back() += c;
  }
  std::erase(parts, "");
  return parts;
}

bool is_index(const std::string& part) { return part.starts_with('['); }

/// Returns true if `part` is an index such as "[1]", or a TOML key that needs no quotes.
bool can_stand_in_a_path(const std::string& part) {
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
  constexpr std::string_view digits = "0123456789";
  if (!is_index(part)) return part.find_first_not_of(letters) == std::string::npos;
  return part.size() > 2 && part.find_first_not_of(digits, 1) == part.size() - 1 && part.ends_with(']');
}

const toml::node* child_of(const toml::node& node, const std::string& part) {
  if (!is_index(part)) return node.is_table() ? node.as_table()->get(part) : nullptr;
  std::size_t index = 0;
  std::from_chars(part.data() + 1, part.data() + part.size(), index);
  return node.is_array() ? node.as_array()->get(index) : nullptr;
}

/// The lines of a table's own keys, without the lines of its sub-tables.
struct OwnLines {
  std::size_t last = 0;
  std::size_t last_key = 0;  ///< line of the table's last key; its value may end on a later line, `last`
  bool has_tables = false;   ///< true if the table has sub-tables with headers of their own
};

using HasHeader = std::function<bool(const toml::node&)>;

void add_lines_of(const toml::node& node, const HasHeader& has_header, OwnLines& lines) {
  if (has_header(node)) {
    lines.has_tables = true;
  } else if (node.is_table() && !node.as_table()->is_inline()) {  // a table that dotted keys (a.b = 1) define
    for (const auto& [key, value] : *node.as_table()) add_lines_of(value, has_header, lines);
  } else if (node.source().end.line > lines.last) {
    lines.last = node.source().end.line;
    lines.last_key = node.source().begin.line;
  }
}

OwnLines own_lines_of(const toml::table& table, const HasHeader& has_header) {
  OwnLines lines{.last = table.source().begin.line, .last_key = table.source().begin.line};
  for (const auto& [key, value] : table) add_lines_of(value, has_header, lines);
  return lines;
}

/// Returns the line `key = value`. Aligns its equals sign with the equals sign of the line `above`, if
/// `above` is the line of a key.
std::string aligned(const std::string& key, const std::string& value, std::string_view above) {
  const std::size_t indent = std::min(above.find_first_not_of(" \t"), above.size());
  const bool is_key = indent < above.size() && above[indent] != '[' && above[indent] != '#';
  const std::size_t equals = is_key ? above.find('=') : std::string_view::npos;
  std::string text = std::string(above.substr(0, indent)) + key;
  if (equals != std::string_view::npos && text.size() + 1 < equals)
    text.append(equals - 1 - text.size(), ' ');
  return text + " = " + value;
}

}  // namespace

/// The result of find(): the parts of a path, and the TOML nodes of those parts that exist.
struct TomlEdit::Place {
  std::vector<std::string> parts;
  std::vector<const toml::node*> nodes;  ///< the root node, then the node of each part that exists
  bool within_inline = false;  ///< true if the last table or key of the path is in an inline table or a
                               ///< list of values

  bool is_complete() const { return nodes.size() == parts.size() + 1; }
  const toml::node& deepest() const { return *nodes.back(); }
  /// Returns the table name that a header [NAME] has: the first `count` parts without indices, joined by
  /// dots.
  std::string header(std::size_t count) const {
    std::string name;
    for (std::size_t i = 0; i < count; ++i)
      if (!is_index(parts[i])) name += (name.empty() ? "" : ".") + parts[i];
    return name;
  }
};

TomlEdit::TomlEdit(std::string text, std::string name) : name_(std::move(name)) { take(std::move(text)); }

TomlEdit TomlEdit::of_file(const std::filesystem::path& file, std::size_t largest) {
  return {read_regular_file(file, largest, a_toml_file), file.string()};
}

void TomlEdit::take(std::string text) {
  root_ = parse_toml(text, name_);
  text_ = std::move(text);
}

void TomlEdit::fail(const toml::source_region& where, const std::string& what) const {
  throw Error({name_, where.begin.line, where.begin.column}, what);
}

std::size_t TomlEdit::line_start(std::size_t line) const {
  std::size_t at = 0;
  for (std::size_t i = 1; i < line; ++i) at = text_.find('\n', at) + 1;
  return at;
}

std::string_view TomlEdit::line_at(std::size_t line) const {
  const std::size_t start = line_start(line);
  return std::string_view(text_).substr(start, text_.find('\n', start) - start);
}

/// Returns the byte offset of a position in the text. The columns of toml++ count characters, not bytes.
std::size_t TomlEdit::offset_of(const toml::source_position& position) const {
  std::size_t at = line_start(position.line);
  if (at == 0 && text_.starts_with(byte_order_mark)) at = byte_order_mark.size();
  const auto continues = [&] {
    return at < text_.size() && (static_cast<unsigned char>(text_[at]) & 0xC0) == 0x80;
  };
  for (std::size_t column = 1; column < position.column; ++column) {
    ++at;
    while (continues()) ++at;
  }
  return at;
}

/// Returns true if the node is a table with a header [NAME], or a list of tables with headers [[NAME]]. An
/// inline table, a value and a table of dotted keys have no header.
bool TomlEdit::has_header(const toml::node& node) const {
  const std::string_view node_text = std::string_view(text_).substr(offset_of(node.source().begin));
  if (const toml::table* table = node.as_table()) return !table->is_inline() && node_text.starts_with('[');
  return node.is_array() && node_text.starts_with("[[") && node.as_array()->is_array_of_tables();
}

TomlEdit::Place TomlEdit::find(const std::string& path) const {
  Place place{.parts = parts_of(path), .nodes = {&root_}};
  for (const std::string& part : place.parts) {
    const toml::node& above = place.deepest();
    const toml::node* node = child_of(above, part);
    if (node == nullptr) break;
    place.within_inline = place.within_inline || (above.is_table() && above.as_table()->is_inline()) ||
                          (above.is_array() && !above.as_array()->is_array_of_tables());
    place.nodes.push_back(node);
  }
  return place;
}

std::string TomlEdit::text_of(const std::string& path) const {
  const toml::source_region at = find(path).deepest().source();
  const std::size_t from = offset_of(at.begin);
  return text_.substr(from, offset_of(at.end) - from);
}

void TomlEdit::replace_value(const toml::source_region& at, const std::string& value) {
  const std::size_t from = offset_of(at.begin), to = offset_of(at.end);
  std::size_t comment = to;
  while (comment < text_.size() && text_[comment] == ' ') ++comment;
  std::string spaces = text_.substr(to, comment - to);
  if (comment < text_.size() && text_[comment] == '#') {  // the comment stays in its column if there is room
    const std::size_t room = comment - from;
    spaces.assign(room > value.size() ? room - value.size() : 1, ' ');
  }
  take(text_.substr(0, from) + value + spaces + text_.substr(comment));
}

void TomlEdit::insert_below(std::size_t line, const std::vector<std::string>& lines) {
  const std::string_view end = text_.find("\r\n") != std::string::npos ? "\r\n" : "\n";
  const std::size_t newline = text_.find('\n', line_start(line));
  const bool is_last = newline == std::string::npos;  // `line` is the last line and has no line end
  std::string text = text_, added;
  for (const std::string& one : lines) added.append(is_last ? end : one).append(is_last ? one : end);
  take(text.insert(is_last ? text.size() : newline + 1, added));
}

void TomlEdit::set(const std::string& path, const std::string& value) {
  if (parse_toml("value = " + value, path).size() != 1)
    throw Error(fmt::format("{} = {}: not a TOML value", path, value),
                expect("for example 1.5, true or \"text\""));
  const Place place = find(path);
  if (!std::ranges::all_of(place.parts, can_stand_in_a_path))
    throw Error(fmt::format("\"{}\" is not a path of keys", path), expect("for example axis[1].control.kp"));
  const toml::node& node = place.deepest();
  const toml::source_region where = node.source();
  if (place.is_complete()) {
    if (node.is_table() || has_header(node))
      fail(where, fmt::format("{} is a table, expected a value", path));
    replace_value(where, value);
    return;
  }
  const std::size_t found = place.nodes.size() - 1, missing = place.parts.size() - found;
  const std::string header = place.header(found);
  if (found == 0 || !node.is_table() || is_index(place.parts[found]) || missing > 2)
    fail(where, fmt::format("the table that contains {} is missing, expected its header", path));
  const toml::table& table = *node.as_table();
  const bool only_implied = std::ranges::any_of(table, [&](const auto& entry) {
    return has_header(entry.second) && entry.second.source().begin == where.begin;
  });
  if (place.within_inline || !has_header(node) || only_implied)
    fail(where, fmt::format("{} is missing, and {} has no header line to add it below, expected a table [{}]",
                            path, header, header));
  const OwnLines own = own_lines_of(table, [this](const toml::node& of) { return has_header(of); });
  if (missing == 1)
    insert_below(own.last, {aligned(place.parts.back(), value, line_at(own.last_key))});
  else
    insert_below(own.last, {"", fmt::format("[{}]", place.header(found + 1)),
                            fmt::format("{} = {}", place.parts.back(), value)});
}

void TomlEdit::set_comment(const std::string& path, const std::string& comment) {
  const Place place = find(path);
  if (!place.is_complete() || place.deepest().is_table()) return;
  const std::size_t behind = offset_of(place.deepest().source().end);
  const std::size_t mark = text_.find_first_not_of(" \t", behind);
  if (mark == std::string::npos || text_[mark] != '#') return;
  const std::size_t end = std::min(text_.find_first_of("\r\n", mark), text_.size());
  take(text_.substr(0, mark) + "# " + comment + text_.substr(end));
}

void TomlEdit::comment_out(const std::string& path) {
  const Place place = find(path);
  if (!place.is_complete()) return;
  const toml::node& node = place.deepest();
  if (place.within_inline || place.nodes.size() < 2 || is_index(place.parts.back()))
    fail(node.source(),
         fmt::format("{} cannot be commented out in a list or inline table, expected a line of its own",
                     path));
  if (node.is_array() && has_header(node))
    fail(node.source(),
         fmt::format("{} cannot be commented out, because it is a list of tables, expected a key or a table",
                     path));
  std::size_t first = node.source().begin.line, last = node.source().end.line;
  if (node.is_table() && !node.as_table()->is_inline()) {
    const OwnLines own =
        own_lines_of(*node.as_table(), [this](const toml::node& of) { return has_header(of); });
    if (own.has_tables || !has_header(node))
      fail(node.source(),
           fmt::format(
               "{} cannot be commented out with its tables or dotted keys, expected [{}] with plain keys",
               path, place.header(place.parts.size())));
    last = own.last;
  }
  std::string text = text_;
  for (std::size_t line = last; line >= first; --line) {
    const std::string_view line_text = line_at(line);
    if (line_text.find_first_not_of(" \t\r") != std::string_view::npos) text.insert(line_start(line), "# ");
  }
  take(std::move(text));
}

}  // namespace hystcan::config
