#include "app/page/config_save.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <regex>
#include <span>
#include <sstream>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/input_file.h"
#include "base/output_file.h"
#include "config/document/toml_edit.h"
#include "config/document/toml_text.h"
#include "config/schema/config.h"

namespace hystcan::app {
namespace {

constexpr std::size_t context_lines = 2;
constexpr std::size_t most_cells = 4'000'000;  // maximum number of cells in the table that compares lines

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Compares two texts line by line with the longest common subsequence. Returns all lines with a mark, for
/// example "- kp = 0" (removed), "+ kp = 1" (added), "  ki = 2" (unchanged).
std::vector<std::string> compare_by_subsequence(std::span<const std::string> before,
                                                std::span<const std::string> after) {
  std::vector<std::vector<std::size_t>> longest(before.size() + 1,
                                                std::vector<std::size_t>(after.size() + 1));
  for (std::size_t i = before.size(); i-- > 0;)
    for (std::size_t k = after.size(); k-- > 0;)
      longest[i][k] =
          before[i] == after[k] ? longest[i + 1][k + 1] + 1 : std::max(longest[i + 1][k], longest[i][k + 1]);
  std::vector<std::string> lines;
  std::size_t i = 0, k = 0;
  while (i < before.size() || k < after.size()) {
    if (i < before.size() && k < after.size() && before[i] == after[k]) {
      lines.push_back("  " + before[i]);
      ++i, ++k;
    } else if (i < before.size() && (k == after.size() || longest[i + 1][k] >= longest[i][k + 1])) {
      lines.push_back("- " + before[i++]);
    } else {
      lines.push_back("+ " + after[k++]);
    }
  }
  return lines;
}

std::vector<std::string> compare(std::span<const std::string> before, std::span<const std::string> after) {
  const auto same = std::mismatch(before.begin(), before.end(), after.begin(), after.end());
  const auto beginning = static_cast<std::size_t>(same.first - before.begin());
  const auto old_rest = before.subspan(beginning), new_rest = after.subspan(beginning);
  const auto same_end = std::mismatch(old_rest.rbegin(), old_rest.rend(), new_rest.rbegin(), new_rest.rend());
  const auto end = static_cast<std::size_t>(same_end.first - old_rest.rbegin());
  const auto removed = old_rest.first(old_rest.size() - end), added = new_rest.first(new_rest.size() - end);
  std::vector<std::string> lines;
  const auto add = [&lines](const char* mark, std::span<const std::string> texts) {
    for (const std::string& text : texts) lines.push_back(mark + text);
  };
  add("  ", before.first(beginning));
  if ((removed.size() + 1) * (added.size() + 1) <= most_cells) {
    const std::vector<std::string> changes = compare_by_subsequence(removed, added);
    lines.insert(lines.end(), changes.begin(), changes.end());
  } else {
    add("- ", removed);
    add("+ ", added);
  }
  add("  ", before.last(end));
  return lines;
}

/// A setting within a segment of the reference. For "axis[0].control.setpoint[2].low_um", list is
/// "axis[0].control.setpoint", index is 2, and key is "low_um".
struct SegmentKey {
  std::string list;
  std::size_t index;
  std::string key;
};

std::optional<SegmentKey> segment_key(const std::string& path) {
  static const std::regex form(fmt::format(R"((axis\[\d+\]\.{}\.{})\[(\d+)\]\.([A-Za-z0-9_.-]+))",
                                           config::control_key, config::setpoint_key));
  std::smatch found;
  if (!std::regex_match(path, found, form)) return std::nullopt;
  return SegmentKey{found[1], std::stoul(found[2]), found[3]};
}

std::size_t last_line_of(const toml::node& node) {
  std::size_t last = node.source().end.line;
  if (const toml::table* table = node.as_table()) {
    last = node.source().begin.line;
    for (const auto& [key, value] : *table) last = std::max(last, last_line_of(value));
  }
  return last;
}

/// Inserts "# " before the lines from `first` to `last`. The first line of the text has the number 1.
void comment_out(std::vector<std::string>& lines, std::size_t first, std::size_t last) {
  for (std::size_t i = first - 1; i < last; ++i)
    if (const auto begin = lines[i].find_first_not_of(" \t\r");
        begin != std::string::npos && lines[i][begin] != '#')
      lines[i].insert(0, "# ");
}

/// Maps the index of a segment to its lines of the form `key = value`.
using Segments = std::map<std::size_t, std::vector<std::string>>;

/// Returns the segments that `unsaved` adds to or removes from each list of segments. A removed segment has
/// no lines. The changes in these segments are removed from `unsaved`.
std::map<std::string, Segments> changed_lists(const toml::table& root, std::vector<config::Change>& unsaved) {
  std::map<std::string, Segments> lists;
  const auto size_of = [&](const std::string& list) {
    const auto node = root.at_path(list);
    return node.is_array_of_tables() ? node.as_array()->size() : 0;
  };
  for (const config::Change& change : unsaved)
    if (const auto key = segment_key(change.path); key && key->key == "kind" && change.to.empty())
      if (size_of(key->list) > 0) lists[key->list][key->index];
  std::erase_if(unsaved, [&](const config::Change& change) {
    const auto key = segment_key(change.path);
    if (!key || size_of(key->list) == 0) return false;
    if (key->index >= size_of(key->list))
      lists[key->list][key->index].push_back(fmt::format("{} = {}", key->key, change.to));
    return lists.contains(key->list) && lists.at(key->list).contains(key->index);
  });
  return lists;
}

/// Returns the text after `segments` were added to or removed from `list`. The list must be written as one
/// TOML value, [{...}, {...}]; with_segments() edits a list of [[...]] tables itself.
std::string with_inline_segments(const std::string& text, const std::string& name, const std::string& list,
                                 std::size_t size, const Segments& segments) {
  config::TomlEdit edit(text, name);
  std::vector<std::string> kept;
  for (std::size_t i = 0; i < size; ++i)
    if (!segments.contains(i)) kept.push_back(edit.text_of(fmt::format("{}[{}]", list, i)));
  for (const auto& [index, keys] : segments)
    if (!keys.empty()) kept.push_back(fmt::format("{{ {} }}", fmt::join(keys, ", ")));
  edit.set(list, fmt::format("[{}]", fmt::join(kept, ", ")));
  return edit.text();
}

/// Returns the text with the changes of whole segments. Added segments are inserted after the last segment of
/// their axis. Removed segments become comments. These changes are removed from `unsaved`.
std::string with_segments(const std::string& text, const std::string& name,
                          std::vector<config::Change>& unsaved) {
  std::string edited = text;
  const auto lists = changed_lists(config::parse_toml(text, name), unsaved);
  for (const auto& [list, segments] : lists) {
    const toml::table root = config::parse_toml(edited, name);
    const toml::array& segment_array = *root.at_path(list).as_array();
    if (segment_array[0].as_table()->is_inline()) {
      edited = with_inline_segments(edited, name, list, segment_array.size(), segments);
      continue;
    }
    std::vector<std::string> lines = lines_of(edited);
    std::vector<std::string> added;
    for (const auto& [index, keys] : segments) {
      if (keys.empty()) {
        comment_out(lines, segment_array[index].source().begin.line, last_line_of(segment_array[index]));
      } else {
        added.insert(added.end(),
                     {"", fmt::format("[[axis.{}.{}]]", config::control_key, config::setpoint_key)});
        added.insert(added.end(), keys.begin(), keys.end());
      }
    }
    if (!added.empty())
      lines.insert(
          lines.begin() + static_cast<std::ptrdiff_t>(last_line_of(segment_array[segment_array.size() - 1])),
          added.begin(), added.end());
    edited = fmt::format("{}{}", fmt::join(lines, "\n"), edited.ends_with('\n') ? "\n" : "");
  }
  return edited;
}

}  // namespace

ConfigSave config_save(const std::string& before, const std::string& text) {
  return {.before = before,
          .text = text,
          .diff = line_diff(before, text),
          .digest = fmt::format("{:016x}", std::hash<std::string>()(before + '\0' + text))};
}

std::string line_diff(const std::string& before, const std::string& after) {
  const std::vector<std::string> old_lines = lines_of(before), new_lines = lines_of(after);
  const std::vector<std::string> lines = compare(old_lines, new_lines);
  std::vector<bool> is_shown(lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (std::size_t k = i - std::min(i, context_lines);
         !lines[i].starts_with(' ') && k < std::min(i + context_lines + 1, lines.size()); ++k)
      is_shown[k] = true;
  std::string text;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!is_shown[i]) continue;
    if (i > 0 && !is_shown[i - 1] && !text.empty()) text += "  ...\n";
    text += lines[i] + "\n";
  }
  return text;
}

ConfigSave save_of(const std::filesystem::path& file, const std::vector<config::Change>& unsaved) {
  const std::string before = config::TomlEdit::of_file(file).text();
  std::vector<config::Change> further = unsaved;
  config::TomlEdit edit(with_segments(before, file.string(), further), file.string());
  for (const config::Change& change : further)
    change.to.empty() ? edit.comment_out(change.path) : edit.set(change.path, change.to);
  try {
    (void)config::load_text(file, edit.text());
  } catch (const Error& error) {
    throw Error("nothing is saved, because the file can no longer be read", error);
  }
  return config_save(before, edit.text());
}

std::filesystem::path kept_beside(const std::filesystem::path& file) {
  return std::filesystem::canonical(file).string() + ".before-save";
}

ConfigSave undo_of(const std::filesystem::path& file) {
  const std::filesystem::path kept = kept_beside(file);
  if (!std::filesystem::exists(kept))
    throw Error(fmt::format("{} is missing, so there is no save to undo", kept.string()));
  (void)config::load(kept);
  // Reads the current file as plain text, because it may be invalid TOML.
  constexpr std::size_t most = config::largest_configuration;
  ConfigSave undo = config_save(read_regular_file(file, most), read_regular_file(kept, most));
  undo.undoes = true;
  return undo;
}

void write_save(const std::filesystem::path& file, const ConfigSave& save) {
  const std::filesystem::path target = std::filesystem::canonical(file);
  OutputFile written(target, OutputFile::Kind::durable);
  written.write(save.text);
  const auto keep_former = [&] {
    try {
      OutputFile kept(kept_beside(file), OutputFile::Kind::durable);
      kept.write(save.before);
      std::filesystem::permissions(kept.written(), std::filesystem::status(target).permissions());
      kept.commit();
    } catch (const std::exception& error) {
      throw RunError(fmt::format("the previous text of the file, which undo needs, cannot be kept{}",
                                 save.undoes ? "" : ", so nothing is saved"),
                     error);
    }
  };
  // Even if the computer crashes here, the text to which the user may return must be in one of the two files:
  // the configuration or FILE.before-save. A save therefore writes FILE.before-save first, and an undo writes
  // the configuration first.
  if (save.undoes) {
    written.commit();
    keep_former();
  } else {
    keep_former();
    written.commit();
  }
}

}  // namespace hystcan::app
