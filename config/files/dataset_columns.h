// Decides which columns of a measured record are time, input and output, and which units they have.
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
  /// Indices of the columns of time, input and output. If a sampling rate is given and no column is a time,
  /// the list has only input and output. If the output has a time column of its own, the index of this column
  /// is last.
  std::vector<std::size_t> selected{};
  bool has_time = false, has_output_time = false;
  std::array<std::string, 3> titles{};  ///< titles of the columns time, input, output
  double seconds = 1.0;  ///< seconds per unit of the time column; with a rate: seconds per sample
  std::optional<double> time_unit_s{};  ///< unit of the time column in seconds; nullopt: it has no unit
  double input_scale = 1.0, output_scale = 1.0;
  std::string input_unit{}, output_unit{};  ///< units of input and output; empty: unknown
  /// True if the columns were selected because their names and units are similar to usual ones. False if the
  /// user selected the columns, or if they have the names time_s, input and output.
  bool by_likeness = false;
};

/// Decides the columns of time, input and output. Throws Error with the place of the header if a column is
/// missing, if two columns are equally likely, if the unit of the time is unknown, or if the input is a
/// position.
DatasetColumns dataset_columns(const LabCsvReader& reader, const DatasetLayout& layout);

/// Decides the columns of a file that has one channel, the input or the output, and perhaps a time. The
/// result names this channel as both input and output. If the file has two columns, the first is the time.
/// The option --columns is TIME,VALUE for both files, or TIME,VALUE,TIME,VALUE for the file of the input and
/// the file of the output; with --rate, TIME is omitted.
DatasetColumns channel_columns(const LabCsvReader& reader, const DatasetLayout& layout,
                               ColumnMeaning channel);

/// Returns a text such as "time from t in ms, input from V, ..." that tells the user which columns were
/// selected by similar names. Returns an empty text if the columns were not selected by similarity.
std::string taken_by_likeness(const LabCsvReader& reader, const DatasetColumns& columns);

/// Returns the numbers of the columns of input and output as a value for the option --columns: "2,3".
std::string columns_without_time(const DatasetColumns& columns);

}  // namespace hystcan::config
