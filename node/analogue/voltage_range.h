// The voltage range of a converter.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace hystcan::node {

/// The voltage range of a converter, in volts.
struct VoltageRange {
  double lo = 0.0;
  double hi = 0.0;
  double step = 0.0;  ///< voltage of the least significant bit, in V; 0: unknown
};

/// Parses a text such as "0..10 V". Returns `nullopt` if the text is not a range.
std::optional<VoltageRange> parsed_range(std::string_view text);

/// Returns a text such as "-1.5 to 20". Writes a negative zero as 0.
std::string from_to(double first, double second);

}  // namespace hystcan::node
