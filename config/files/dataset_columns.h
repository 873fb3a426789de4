// Which columns of a record are time, input and output, and in what units.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "config/files/dataset_file.h"
#include "config/files/lab_csv.h"
#include "config/files/record_words.h"

namespace hystcan::config {

struct DatasetColumns {
  /// Time, input, output; without time if a rate is given and no column is one. Last the output's own time,
  /// if it has one.
  std::vector<std::size_t> selected{};
  bool has_time = false, has_output_time = false;
  std::array<std::string, 3> titles{};  ///< time, input, output
  double seconds = 1.0;                 ///< of one unit of time, or of one sample where a rate is stated
  std::optional<double> time_unit_s{};  ///< where the column states a unit
  double input_scale = 1.0, output_scale = 1.0;
  std::string input_unit{}, output_unit{};  ///< empty: unknown
  bool by_likeness = false;                 ///< else the names are time_s, input, output, or the user's
};

/// Throws Error at the header if a column is missing or if two are alike, if a unit of time is not known, and
/// if the input is a position.
DatasetColumns dataset_columns(const LabCsvReader& reader, const DatasetLayout& layout);

/// Of a file with one channel, the input or the output, whose values are both input and output here: of two
/// columns the first is the time, and --columns is TIME,VALUE, and a second pair for the output's file.
DatasetColumns channel_columns(const LabCsvReader& reader, const DatasetLayout& layout,
                               ColumnMeaning channel);

/// "time from t in ms, input from V, ..." of columns that were taken by likeness; else empty.
std::string taken_by_likeness(const LabCsvReader& reader, const DatasetColumns& columns);

/// The numbers of input and output for --columns: "2,3".
std::string columns_without_time(const DatasetColumns& columns);

}  // namespace hystcan::config
