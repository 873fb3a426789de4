// A measured dataset: the applied input and the measured output.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace hystcan::identification {

/// Columns of equal length. Every number is finite, and time increases strictly.
struct Dataset {
  std::string input_unit;  ///< empty: unknown
  std::string output_unit;
  std::vector<double> time_s;
  std::vector<double> input;
  std::vector<double> output;

  std::size_t size() const { return input.size(); }
};

}  // namespace hystcan::identification
