#include "config/document/closest.h"

#include <algorithm>
#include <cctype>
#include <numeric>
#include <utility>

namespace hystcan::config {
namespace {

constexpr std::size_t most_shown = 5;

int lower(char letter) { return std::tolower(static_cast<unsigned char>(letter)); }

/// Levenshtein distance: the fewest insertions, deletions and substitutions that turn one text into the
/// other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t exchanged = diagonal + (lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, exchanged});
    }
  }
  return row[b.size()];
}

using Ranked = std::pair<std::size_t, std::string>;

/// The nearest first.
std::vector<Ranked> by_distance(std::string_view name, const std::vector<std::string>& candidates) {
  std::vector<Ranked> ranked;
  ranked.reserve(candidates.size());
  for (const std::string& candidate : candidates)
    ranked.emplace_back(edit_distance(name, candidate), candidate);
  std::ranges::stable_sort(ranked, {}, &Ranked::first);
  return ranked;
}

}  // namespace

std::string closest(std::string_view name, const std::vector<std::string>& candidates) {
  const std::vector<Ranked> ranked = by_distance(name, candidates);
  std::string text;
  for (std::size_t i = 0; i < std::min(most_shown, ranked.size()); ++i)
    text += (i == 0 ? "" : ", ") + ranked[i].second;
  return text.empty() ? "none" : text;
}

std::optional<std::string> meant_by(std::string_view name, const std::vector<std::string>& candidates) {
  const std::vector<Ranked> ranked = by_distance(name, candidates);
  if (ranked.empty() || 3 * ranked.front().first > std::max(name.size(), ranked.front().second.size()))
    return std::nullopt;
  return ranked.front().second;
}

}  // namespace hystcan::config
