// Decides which columns of a record are time, input and output, and their units.
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
  /// Indices of time, input and output; without time if a rate is given and no column is a time. If the
  /// output has a time column of its own, its index is last.
  std::vector<std::size_t> selected{};
  bool has_time = false, has_output_time = false;
  std::array<std::string, 3> titles{};  ///< time, input, output
  double seconds = 1.0;                 ///< duration of one unit of time, or of one sample if a rate is given
  std::optional<double> time_unit_s{};  ///< unit of the time column, if it has one
  double input_scale = 1.0, output_scale = 1.0;
  std::string input_unit{}, output_unit{};  ///< empty if unknown
  bool by_likeness = false;                 ///< selected by similar names and units; else by the names
                                            ///< time_s, input, output, or by the user
};

/// Throws Error at the header if a column is missing or two columns are equally likely, if a time unit is not
/// known, or if the input is a position.
DatasetColumns dataset_columns(const LabCsvReader& reader, const DatasetLayout& layout);

/// Decides the columns of a file with one channel, the input or the output; its values are used as both input
/// and output. Of two columns, the first is the time. --columns is TIME,VALUE, followed by a second pair for
/// the output's file.
DatasetColumns channel_columns(const LabCsvReader& reader, const DatasetLayout& layout,
                               ColumnMeaning channel);

/// Returns "time from t in ms, input from V, ..." for columns that were selected by similarity; else an empty
/// text.
std::string taken_by_likeness(const LabCsvReader& reader, const DatasetColumns& columns);

/// Returns the column numbers of input and output for --columns: "2,3".
std::string columns_without_time(const DatasetColumns& columns);

}  // namespace hystcan::config
