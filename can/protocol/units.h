// Converts the unit of a DBC to ours if the two differ only by a decimal prefix: mV to V, nm to um, mA to A.
//
//   ours = theirs * 10^n,   n = exponent(their prefix) - exponent(our prefix)
//
// The step is exact: a double holds the whole number 10^|n|, and one multiplication or division by it rounds
// once. A value that is converted and converted back differs at most in its last bit or two, far below the
// resolution of any signal.
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

/// Empty if the units do not convert, because they differ by more than a prefix. Known prefixes: p, n, u
/// (also written with a micro sign), m, none, k, M.
std::optional<DecimalStep> decimal_step(std::string_view theirs, std::string_view ours);

}  // namespace hystcan::can
