#include "config/document/closest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <numeric>
#include <utility>

namespace hystcan::config {
namespace {

constexpr std::size_t most_shown = 5;

int lower(char letter) { return std::tolower(static_cast<unsigned char>(letter)); }

/// Returns the Levenshtein distance: the smallest number of insertions, deletions and substitutions that turn
/// one text into the other.
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

}  // namespace

std::string closest(std::string_view name, const std::vector<std::string>& candidates) {
  std::vector<std::string> nearest = candidates;
  std::ranges::stable_sort(nearest, {}, [&](const std::string& of) { return edit_distance(name, of); });
  nearest.resize(std::min(most_shown, nearest.size()));
  return nearest.empty() ? "none" : fmt::format("{}", fmt::join(nearest, ", "));
}

std::optional<std::string> meant_by(std::string_view name, const std::vector<std::string>& candidates) {
  if (candidates.empty()) return std::nullopt;
  const std::string nearest =
      std::ranges::min(candidates, {}, [&](const std::string& of) { return edit_distance(name, of); });
  if (3 * edit_distance(name, nearest) > std::max(name.size(), nearest.size())) return std::nullopt;
  return nearest;
}

}  // namespace hystcan::config
