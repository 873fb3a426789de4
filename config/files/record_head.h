// Reads the head of a measured record, which is all text above the rows. The head has names and units of the
// columns, and the sampling rate. Each of these may be missing.
//
//   names   the nearest line above the rows that has a field for each column; the line may begin with #
//   units   part of the names: `drive (V)`, `x [um]`, `time_s`; or a line of their own between the names and
//           the rows; or instrument settings: `Vertical Units,V`
//   rate    `Abtastrate: 5000 Hz`, `Sample Interval,1e-3`, `Delta_X`, or `Increment` above its number
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "config/files/csv_column.h"
#include "config/files/record_text.h"
#include "config/files/row_shape.h"

namespace hystcan::config {

/// A sampling rate that the head of a record states. An ambiguous rate such as 5.000 Hz, in which the point
/// may be a thousands sign, is ignored.
struct StatedRate {
  double rate_Hz = 0.0;
  std::string line{};  ///< line of the file that states the rate
};

struct RecordHead {
  std::vector<CsvColumn> columns{};  ///< columns of the record; without names in the head, named 1, 2, 3 ...
  bool has_names = false;
  std::size_t line = 1;              ///< number of the line with the column names
  std::optional<StatedRate> rate{};  ///< sampling rate in the head; nullopt: no rate, or two different rates
  std::vector<std::string> comments{};
};

/// Reads the head of a record. `lines` are all lines above the rows. `beside` are the rows that have
/// instrument settings to the left of their numbers.
RecordHead read_head(const std::vector<TextLine>& lines, const RowShape& shape,
                     const std::vector<TextLine>& beside);

}  // namespace hystcan::config
