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
  double step = 0.0;  ///< least significant bit; 0: unknown
};

/// Parses a text such as "0..10 V". Returns `nullopt` if the text is not a range.
std::optional<VoltageRange> parsed_range(std::string_view text);

/// Returns, for example, "-1.5 to 20"; a negative zero becomes 0.
std::string from_to(double first, double second);

}  // namespace hystcan::node
