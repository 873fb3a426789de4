// Finds the names that a misspelt name probably means.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::config {

/// The candidates with the least edit distance to `name`, regardless of case: "A, B, C"; `none` if there are
/// no candidates.
std::string closest(std::string_view name, const std::vector<std::string>& candidates);

/// The candidate with the least edit distance to `name`; empty if it is no likely misspelling: more than a
/// third of the letters differ.
std::optional<std::string> meant_by(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace hystcan::config
