// Which columns of a lab's CSV are time, input and output, and in what units.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/files/lab_csv.h"

namespace hystcan::config {

/// What the user says about the file.
struct DatasetLayout {
  std::string columns{};  ///< "t,V,x": names or numbers of time, input and output; empty: by likeness
  std::optional<double> rate_Hz{};       ///< there is no time, or it is the number of the sample
  std::optional<double> output_scale{};  ///< um of one unit of the output column
};

inline constexpr std::array<std::string_view, 3> column_meanings{"time", "input", "output"};

struct DatasetColumns {
  std::vector<std::size_t>
      selected;  ///< time, input, output; without time if rate_Hz is given and no column is one
  std::array<std::string, 3> titles;    ///< time, input, output
  double seconds = 1.0;                 ///< of one unit of time, or of one sample where a rate is stated
  std::optional<double> time_unit_s{};  ///< where the column states a unit
  double input_scale = 1.0, output_scale = 1.0;
  std::string input_unit, output_unit;  ///< empty: unknown
  bool by_likeness = false;             ///< else the names are time_s, input, output, or the user's

  bool has_time() const { return selected.size() == 3; }
};

/// Throws Error at the header if a column is missing or if two are alike.
DatasetColumns dataset_columns(const LabCsvReader& reader, const DatasetLayout& layout);

}  // namespace hystcan::config
