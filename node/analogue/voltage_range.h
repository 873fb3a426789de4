// The range of a converter.
#pragma once

#include <optional>
#include <string_view>

namespace hystcan::node {

/// Volts.
struct VoltageRange {
  double lo = 0.0;
  double hi = 0.0;
  double step = 0.0;  ///< least significant bit; 0: not known
};

/// "0..10 V"; empty: another text.
std::optional<VoltageRange> parsed_range(std::string_view text);

}  // namespace hystcan::node
