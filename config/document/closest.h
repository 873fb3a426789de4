// Finds the known names that are most similar to a misspelt name, for error messages.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::config {

/// Returns up to five candidates, the most similar to `name` first, as text: "A, B, C". Upper and lower case
/// count as equal. Returns "none" if there are no candidates.
std::string closest(std::string_view name, const std::vector<std::string>& candidates);

/// Returns the candidate with the smallest edit distance to `name`. Returns nullopt if more than a third of
/// the letters differ, because then `name` is probably not a misspelling of the candidate.
std::optional<std::string> meant_by(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace hystcan::config
