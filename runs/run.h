// A recorded run, for reading: a run's folder, one part of it, or a CSV with columns of cycles
// (`controller --csv`, `demo`, a black box).
//
// A run that was killed, or that is still being recorded, is read up to its last complete line, with a note.
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

/// A range of time_s, both ends included.
struct TimeSpan {
  double from_s = -std::numeric_limits<double>::infinity();
  double to_s = std::numeric_limits<double>::infinity();
};

/// A column: its name, its unit with the drive unit resolved ("V"), and the words of a state or cause.
using Signal = storage::Column;

/// Columns of equal length, in the requested order; NaN if a row has no value.
using Columns = std::vector<std::vector<double>>;

class Run {
 public:
  /// Throws Error if the path is neither a run's folder nor a CSV of cycles.
  explicit Run(std::filesystem::path path);

  const std::filesystem::path& path() const { return path_; }
  /// For a single CSV, only axes and rows are determined; the rest is empty.
  const RunInfo& info() const { return info_; }
  /// The name of the folder or file, for titles: run_20261123T092000.123Z.
  std::string name() const;
  /// Returns "FILE: ignoring the last row: it has no line end and may be incomplete" for each such part.
  /// Reads the end of each part.
  std::vector<std::string> notes() const;
  std::size_t axis_index(const std::string& axis) const;
  /// Returns all columns of the CSV except `axis`.
  std::vector<Signal> signals(std::size_t axis) const;
  /// Returns these columns, which must be columns of cycles.
  std::vector<Signal> signals(std::size_t axis, std::span<const std::string> names) const;

  /// Reads these columns of one axis; `names` as in cycles_*.csv. Throws Error at a name that the run does
  /// not have, and at a row that is not a cycle: FILE:LINE:COLUMN: PROBLEM, expected ...
  Columns read(std::size_t axis, std::span<const std::string> names, const TimeSpan& span = {}) const;

  /// Reads in constant memory: calls `take` with blocks of the columns of these axes, for each axis in order
  /// of time.
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
