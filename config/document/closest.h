// What was probably meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hystcan::config {

/// The candidates nearest to `name` by edit distance, letters' case aside: "A, B, C"; `none` if there is
/// none.
std::string closest(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace hystcan::config
