#include "app/page/config_save.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <string_view>
#include <vector>

#include "app/page/segment_edit.h"
#include "base/error.h"
#include "base/output_file.h"
#include "config/document/toml_edit.h"
#include "config/schema/config.h"

namespace hystcan::app {
namespace {

constexpr std::size_t context_lines = 2;
constexpr std::size_t most_cells = 4'000'000;  // of the table of a comparison

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

struct DiffLine {
  char mark;
  std::string_view text;
};

/// By the longest common subsequence.
std::vector<DiffLine> compare_by_subsequence(std::span<const std::string> before,
                                             std::span<const std::string> after) {
  std::vector<std::vector<std::size_t>> longest(before.size() + 1,
                                                std::vector<std::size_t>(after.size() + 1));
  for (std::size_t i = before.size(); i-- > 0;)
    for (std::size_t k = after.size(); k-- > 0;)
      longest[i][k] =
          before[i] == after[k] ? longest[i + 1][k + 1] + 1 : std::max(longest[i + 1][k], longest[i][k + 1]);
  std::vector<DiffLine> lines;
  std::size_t i = 0, k = 0;
  while (i < before.size() || k < after.size()) {
    if (i < before.size() && k < after.size() && before[i] == after[k]) {
      lines.push_back({' ', before[i]});
      ++i, ++k;
    } else if (i < before.size() && (k == after.size() || longest[i + 1][k] >= longest[i][k + 1])) {
      lines.push_back({'-', before[i++]});
    } else {
      lines.push_back({'+', after[k++]});
    }
  }
  return lines;
}

std::vector<DiffLine> compare(std::span<const std::string> before, std::span<const std::string> after) {
  const auto same = std::mismatch(before.begin(), before.end(), after.begin(), after.end());
  const auto beginning = static_cast<std::size_t>(same.first - before.begin());
  const auto old_rest = before.subspan(beginning), new_rest = after.subspan(beginning);
  const auto same_end = std::mismatch(old_rest.rbegin(), old_rest.rend(), new_rest.rbegin(), new_rest.rend());
  const auto end = static_cast<std::size_t>(same_end.first - old_rest.rbegin());
  const auto gone = old_rest.first(old_rest.size() - end), come = new_rest.first(new_rest.size() - end);
  std::vector<DiffLine> lines;
  const auto add = [&lines](char mark, std::span<const std::string> texts) {
    for (const std::string& text : texts) lines.push_back({mark, text});
  };
  add(' ', before.first(beginning));
  if ((gone.size() + 1) * (come.size() + 1) <= most_cells) {
    const std::vector<DiffLine> between = compare_by_subsequence(gone, come);
    lines.insert(lines.end(), between.begin(), between.end());
  } else {
    add('-', gone);
    add('+', come);
  }
  add(' ', before.last(end));
  return lines;
}

ConfigSave config_save(const std::string& before, const std::string& text) {
  return {.before = before,
          .text = text,
          .diff = line_diff(before, text),
          .digest = fmt::format("{:016x}", std::hash<std::string>()(before + '\0' + text))};
}

}  // namespace

std::string line_diff(const std::string& before, const std::string& after) {
  const std::vector<std::string> old_lines = lines_of(before), new_lines = lines_of(after);
  const std::vector<DiffLine> lines = compare(old_lines, new_lines);
  std::vector<bool> is_shown(lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (std::size_t k = i - std::min(i, context_lines);
         lines[i].mark != ' ' && k < std::min(i + context_lines + 1, lines.size()); ++k)
      is_shown[k] = true;
  std::string text;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!is_shown[i]) continue;
    if (i > 0 && !is_shown[i - 1] && !text.empty()) text += "  ...\n";
    text += fmt::format("{} {}\n", lines[i].mark, lines[i].text);
  }
  return text;
}

ConfigSave save_of(const std::filesystem::path& file, const nlohmann::json& unsaved) {
  const std::string before = config::TomlEdit::of_file(file).text();
  nlohmann::json further = unsaved;
  config::TomlEdit edit(with_segments(before, file.string(), further), file.string());
  for (const nlohmann::json& change : further) {
    const auto& key = change.at("key").get_ref<const std::string&>();
    const auto& value = change.at("to").get_ref<const std::string&>();
    if (value.empty())
      edit.comment_out(key);
    else
      edit.set(key, value);
  }
  return config_save(before, edit.text());
}

std::filesystem::path kept_beside(const std::filesystem::path& file) {
  return std::filesystem::canonical(file).string() + ".before-save";
}

ConfigSave undo_of(const std::filesystem::path& file) {
  const std::filesystem::path kept = kept_beside(file);
  if (!std::filesystem::exists(kept))
    throw Error(fmt::format("there is no {}, so there is no save to undo", kept.string()));
  (void)config::load(kept);
  ConfigSave undo =
      config_save(config::TomlEdit::of_file(file).text(), config::TomlEdit::of_file(kept).text());
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
      throw RunError(fmt::format("the former file cannot be kept{}: {}",
                                 save.undoes ? "" : ", so nothing is saved", error.what()));
    }
  };
  // At every moment one of the two files has what the user wants back.
  if (save.undoes) {
    written.commit();
    keep_former();
  } else {
    keep_former();
    written.commit();
  }
}

}  // namespace hystcan::app
