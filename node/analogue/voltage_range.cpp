#include "node/analogue/voltage_range.h"

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

}  // namespace hystcan::node
