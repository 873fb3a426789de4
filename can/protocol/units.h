// From a DBC's unit to ours, where the two differ by a decimal prefix only: mV to V, nm to um, mA to A.
//
//   ours = theirs * 10^n,   n = exponent(their prefix) - exponent(our prefix)
//
// The step is exact: 10^|n| is a whole number that a double holds, and one multiplication or one division by
// it is rounded once. What is converted and converted back is the value it was, to its last bit or two, far
// below the resolution of any signal.
#pragma once

#include <optional>
#include <string_view>

namespace hystcan::can {

class DecimalStep {
 public:
  double to_ours(double theirs) const { return theirs * multiplier_ / divisor_; }
  double to_theirs(double ours) const { return ours * divisor_ / multiplier_; }

 private:
  friend std::optional<DecimalStep> decimal_step(std::string_view theirs, std::string_view ours);
  double multiplier_ = 1.0;  ///< one of the two is 1
  double divisor_ = 1.0;
};

/// Empty where the units do not convert: another base unit, or one that differs by more than a prefix. Known
/// prefixes: p, n, u (also written with a micro sign), m, none, k, M.
std::optional<DecimalStep> decimal_step(std::string_view theirs, std::string_view ours);

}  // namespace hystcan::can
