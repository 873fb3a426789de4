// A measured dataset: the applied input and the measured output.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace hystcan::identification {

/// Limits of inputs and outputs in their units, and of times in s: beyond them, squares and powers of a fit overflow or
/// vanish. A column that moves, moves by `least_span` at least.
inline constexpr double largest_value = 1e12;
inline constexpr double least_span = 1e-12;

/// Columns of equal length. Every number is finite and within the limits, and time increases strictly.
struct Dataset {
  std::string input_unit;  ///< empty: unknown
  std::string output_unit;
  std::vector<double> time_s;
  std::vector<double> input;
  std::vector<double> output;
  std::vector<double> weight{};  ///< of each sample's error in a fit; empty: all 1
  std::vector<std::vector<double>>
      regressors{};  ///< columns that are fitted to it beside the curves, not weighted

  std::size_t size() const { return input.size(); }
};

/// Time from -1/2 at the first sample to 1/2 at the last one: the course of a linear drift.
inline double drift_course(std::span<const double> time_s, std::size_t i) {
  return (time_s[i] - time_s.front()) / (time_s.back() - time_s.front()) - 0.5;
}

}  // namespace hystcan::identification
