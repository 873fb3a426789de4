// A measured dataset: what was applied and what came of it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace hystcan::identification {

/// Columns of equal length; every number finite, time strictly increasing.
struct Dataset {
  std::string input_unit;  ///< empty: the dataset does not tell
  std::string output_unit;
  std::vector<double> time_s;
  std::vector<double> input;
  std::vector<double> output;

  std::size_t size() const { return input.size(); }
};

}  // namespace hystcan::identification
