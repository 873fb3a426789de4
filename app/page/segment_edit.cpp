#include "app/page/segment_edit.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <sstream>
#include <vector>

#include "config/document/toml_text.h"

namespace hystcan::app {
namespace {

using nlohmann::json;

/// "axis[0].control.setpoint[2].low_um": the list, the index in it, the key.
struct SegmentKey {
  std::string list;
  std::size_t index;
  std::string key;
};

std::optional<SegmentKey> segment_key(const std::string& path) {
  static const std::regex form(R"((axis\[\d+\]\.control\.setpoint)\[(\d+)\]\.([A-Za-z0-9_.-]+))");
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

class Lines {
 public:
  explicit Lines(const std::string& text) {
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines_.push_back(line);
    ends_ = text.ends_with('\n');
  }

  /// Line numbers count from 1.
  void comment_out(std::size_t first, std::size_t last) {
    for (std::size_t i = first - 1; i < last; ++i)
      if (const auto begin = lines_[i].find_first_not_of(" \t\r");
          begin != std::string::npos && lines_[i][begin] != '#')
        lines_[i].insert(0, "# ");
  }
  void insert_below(std::size_t line, const std::vector<std::string>& added) {
    lines_.insert(lines_.begin() + static_cast<std::ptrdiff_t>(line), added.begin(), added.end());
  }
  std::string text() const { return fmt::format("{}{}", fmt::join(lines_, "\n"), ends_ ? "\n" : ""); }

 private:
  std::vector<std::string> lines_;
  bool ends_ = false;
};

using Segments = std::map<std::size_t, std::vector<std::string>>;  ///< index -> lines `key = value`

/// The segments of a list that are new, or gone: their lines are empty then.
std::map<std::string, Segments> changed_lists(const toml::table& root, json& unsaved) {
  std::map<std::string, Segments> lists;
  json further = json::array();
  const auto size_of = [&](const std::string& list) {
    const auto node = root.at_path(list);
    return node.is_array_of_tables() ? node.as_array()->size() : 0;
  };
  const auto is_gone = [&](const SegmentKey& key) {
    return std::ranges::any_of(unsaved, [&](const json& change) {
      return change.at("key") == fmt::format("{}[{}].kind", key.list, key.index) &&
             change.at("to").get_ref<const std::string&>().empty();
    });
  };
  for (const json& change : unsaved) {
    const auto key = segment_key(change.at("key"));
    const std::size_t size = key ? size_of(key->list) : 0;
    const bool is_new = size > 0 && key->index >= size;
    if (is_new)
      lists[key->list][key->index].push_back(
          fmt::format("{} = {}", key->key, change.at("to").get<std::string>()));
    else if (size > 0 && is_gone(*key))
      lists[key->list][key->index];
    else
      further.push_back(change);
  }
  unsaved = std::move(further);
  return lists;
}

}  // namespace

std::string with_segments(const std::string& text, const std::string& name, json& unsaved) {
  std::string edited = text;
  const auto lists = changed_lists(config::parse_toml(text, name), unsaved);
  for (const auto& [list, segments] : lists) {
    const toml::table root = config::parse_toml(edited, name);
    const toml::array& there = *root.at_path(list).as_array();
    Lines lines(edited);
    std::vector<std::string> added;
    for (const auto& [index, keys] : segments) {
      if (keys.empty()) {
        lines.comment_out(there[index].source().begin.line, last_line_of(there[index]));
      } else {
        added.insert(added.end(), {"", "[[axis.control.setpoint]]"});
        added.insert(added.end(), keys.begin(), keys.end());
      }
    }
    if (!added.empty()) lines.insert_below(last_line_of(there[there.size() - 1]), added);
    edited = lines.text();
  }
  return edited;
}

}  // namespace hystcan::app
