// Reads a recorded run. The run is a run's folder, one CSV of such a folder, or another CSV with one row per
// control cycle (written by `controller --csv`, by `demo`, or by the black box after a fault).
//
// If the program that recorded the run was killed, or is still recording, the run is read up to its last
// complete line. notes() reports the incomplete line.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runs/run_info.h"
#include "storage/hdf5.h"

namespace hystcan::runs {

/// A range of the times in the column time_s, both ends included.
struct TimeSpan {
  double from_s = -std::numeric_limits<double>::infinity();
  double to_s = std::numeric_limits<double>::infinity();
};

/// A column of a run: its name, its unit and, for a column of states or causes, the words for its values. The
/// unit of a drive is the axis's own unit, for example "V".
using Signal = storage::Column;

/// The values of the requested columns, in the requested order. All columns have the same length. A missing
/// value is NaN.
using Columns = std::vector<std::vector<double>>;

class Run {
 public:
  /// Throws Error if the path is neither a run's folder nor a CSV of cycles.
  explicit Run(std::filesystem::path path);

  const std::filesystem::path& path() const { return path_; }
  /// Returns the description of the run. For a CSV outside a run's folder the description has only the values
  /// that the rows give: axes, errors, faults, times and the number of rows. The other members are empty.
  const RunInfo& info() const { return info_; }
  /// Returns the name of the run's folder or file, for titles. Example: run_20261123T092000.123Z.
  std::string name() const;
  /// Returns a note for each CSV of the run that ends with an incomplete row. Example: "FILE: ignoring the
  /// last row: it has no line end and may be incomplete".
  std::vector<std::string> notes() const;
  std::size_t axis_index(const std::string& axis) const;
  /// Returns all columns of the run's CSV except the column `axis`. The argument is the axis whose drive unit
  /// the columns get.
  std::vector<Signal> signals(std::size_t axis) const;
  /// Returns the columns with these names, in this order. Each name must be a column of cycles
  /// (controller/cycle_record.h).
  std::vector<Signal> signals(std::size_t axis, std::span<const std::string> names) const;

  /// Reads columns of one axis. `names` are column names of cycles_*.csv. Throws Error if the run lacks a
  /// column, or if a row is invalid: FILE:LINE:COLUMN: PROBLEM, expected ...
  Columns read(std::size_t axis, std::span<const std::string> names, const TimeSpan& span = {}) const;

  /// Reads columns of several axes in constant memory. Calls `take` for each block of rows; a block has the
  /// rows of one axis. The blocks of an axis are in the order of time.
  using Block = std::function<void(std::size_t axis, std::span<const std::vector<double>> columns)>;
  void read_blocks(std::span<const std::size_t> axes, std::span<const std::string> names,
                   const TimeSpan& span, const Block& take) const;

 private:
  void look_through();
  void read_part(
      const std::filesystem::path& part, std::span<const std::string> names, const TimeSpan& span,
      const std::function<void(std::string_view axis, const std::vector<double>& row)>& take) const;

  std::filesystem::path path_;
  std::vector<std::filesystem::path> parts_;
  std::vector<std::string> header_;
  RunInfo info_;
};

}  // namespace hystcan::runs
