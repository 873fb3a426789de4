#include "config/document/format.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "config/document/toml_edit.h"
#include "config/document/toml_text.h"

namespace hystcan::config {
namespace {

static_assert(newest_format == 1 && format_line == "format = 1\n");

/// "[]" in the path stands for every element of a list.
struct Gone {
  std::string_view path;
  std::string_view now;
};

constexpr std::array<Gone, 1> gone{
    {{"axis[].control.adaptation", "no longer exists: it made the true error 2 to 7 % worse"}}};

/// The path for each element of its list, which may be absent.
std::vector<std::string> expanded(std::string_view path, const toml::table& root) {
  const std::size_t mark = path.find("[]");
  if (mark == std::string_view::npos) return {std::string(path)};
  const toml::array* list = root.at_path(path.substr(0, mark)).as_array();
  std::vector<std::string> paths;
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i)
    paths.push_back(fmt::format("{}[{}]{}", path.substr(0, mark), i, path.substr(mark + 2)));
  return paths;
}

/// Behind the comments at the beginning of the file.
std::string with_format_line(std::string text) {
  const std::string_view end = text.find("\r\n") != std::string::npos ? "\r\n" : "\n";
  const auto line_at = [&](std::size_t from) {
    return std::string_view(text).substr(from, text.find('\n', from) - from);
  };
  std::size_t at = text.starts_with(byte_order_mark) ? byte_order_mark.size() : 0;
  const bool has_heading = line_at(at).starts_with('#');
  while (line_at(at).starts_with('#')) {
    if (text.find('\n', at) == std::string::npos) text.append(end);
    at = text.find('\n', at) + 1;
  }
  std::string line = fmt::format("format = {}{}", newest_format, end);
  const std::string_view next = line_at(at);
  const bool is_blank = next.empty() || next == "\r";
  if (has_heading && is_blank) line.insert(0, end);
  if (next.starts_with('[')) line.append(end);
  return text.insert(at, line);
}

}  // namespace

int format_of(const toml::table& root, const std::string& name) {
  const toml::node* node = root.get("format");
  if (node == nullptr) return 0;
  const auto format = node->value_exact<std::int64_t>();
  const toml::source_position place = node->source().begin;
  if (!format || *format < 1)
    throw Error(fmt::format("{}:{}:{}: format is no number of a format, expected {}", name, place.line,
                            place.column, newest_format));
  if (*format > newest_format)
    throw Error(fmt::format("{}:{}:{}: format is {}, written for a newer hystcan, expected at most {}", name,
                            place.line, place.column, *format, newest_format));
  return static_cast<int>(*format);
}

std::vector<FormerKey> former_keys(const toml::table& root) {
  std::vector<FormerKey> found;
  for (const Gone& one : gone)
    for (std::string& path : expanded(one.path, root))
      if (root.at_path(path)) found.push_back({std::move(path), one.now});
  return found;
}

Migration migrate(const std::string& text, const std::string& name) {
  const toml::table root = parse_toml(text, name);
  const int from = format_of(root, name);
  TomlEdit edit(text, name);
  for (const FormerKey& key : former_keys(root)) edit.comment_out(key.path);
  if (from == 0) return {from, with_format_line(edit.text())};
  edit.set("format", std::to_string(newest_format));
  return {from, edit.text()};
}

}  // namespace hystcan::config
