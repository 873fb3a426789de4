// Finds the names that a misspelt name probably means.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::config {

/// Returns the candidates with the smallest edit distance to `name`, ignoring case: "A, B, C"; `none` if
/// there are no candidates.
std::string closest(std::string_view name, const std::vector<std::string>& candidates);

/// Returns the candidate with the smallest edit distance to `name`; nullopt if more than a third of the
/// letters differ, which is unlikely to be a misspelling.
std::optional<std::string> meant_by(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace hystcan::config
