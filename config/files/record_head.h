// The head of a measured record: names and units of the columns, and the sampling rate. Each may be missing.
//
//   names   the nearest line above the rows with a field for each column, also after #
//   units   in the names, `drive (V)`, `x [um]`, `time_s`; in a line between the names and the rows; or
//           settings: `Vertical Units,V`
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

/// A sampling rate in the head. Ignored if its point may be a thousands sign (5.000 Hz).
struct StatedRate {
  double rate_Hz = 0.0;
  std::string line{};  ///< as in the file
};

struct RecordHead {
  std::vector<CsvColumn> columns{};  ///< named 1, 2, 3 ... if there are no names
  bool has_names = false;
  std::size_t line = 1;              ///< line of the names
  std::optional<StatedRate> rate{};  ///< nullopt if there are two different rates
  std::vector<std::string> comments{};
};

/// `lines`: all lines above the rows; `beside`: rows with settings to their left.
RecordHead read_head(const std::vector<TextLine>& lines, const RowShape& shape,
                     const std::vector<TextLine>& beside);

}  // namespace hystcan::config
