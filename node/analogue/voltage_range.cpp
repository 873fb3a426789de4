#include "node/analogue/voltage_range.h"

#include <fmt/format.h>

#include <cmath>

#include "base/text.h"

namespace hystcan::node {

std::optional<VoltageRange> parsed_range(std::string_view text) {
  const auto dots = text.find("..");
  if (dots == std::string_view::npos || !text.ends_with(" V")) return std::nullopt;
  const auto lo = parsed_number<double>(text.substr(0, dots));
  const auto hi = parsed_number<double>(text.substr(dots + 2, text.size() - dots - 4));
  if (!lo || !hi || !(*lo < *hi) || !std::isfinite(*lo) || !std::isfinite(*hi)) return std::nullopt;
  return VoltageRange{.lo = *lo, .hi = *hi};
}

std::string from_to(double first, double second) {
  return fmt::format("{:.4g} to {:.4g}", first + 0.0, second + 0.0);  // -0.0 + 0.0 is 0.0
}

}  // namespace hystcan::node
