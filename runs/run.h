// A recorded run, to be read: a run's folder, one part of it, or a CSV with columns of cycles (`controller
// --csv`, `demo`, a black box).
//
// A run that was killed, or that is still being recorded, is read up to its last whole line, with a note.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/files/csv.h"
#include "controller/cycle_record.h"
#include "runs/run_info.h"
#include "storage/hdf5.h"

namespace hystcan::runs {

/// Of time_s, both ends included.
struct TimeSpan {
  double from_s = -std::numeric_limits<double>::infinity();
  double to_s = std::numeric_limits<double>::infinity();
};

/// A column: its name, its unit with the drive unit resolved ("V"), and the words of a state or cause.
using Signal = storage::Column;

/// Columns of equal length, in the order in which they were asked for; NaN where a row has no value.
using Columns = std::vector<std::vector<double>>;

class Run {
 public:
  /// Throws Error if it is neither a run's folder nor a CSV of cycles.
  explicit Run(std::filesystem::path path);

  const std::filesystem::path& path() const { return path_; }
  /// For a single CSV: axes and rows are counted, the rest is empty.
  const RunInfo& info() const { return info_; }
  /// The folder's or file's name, for titles: run_20261123T092000.123Z.
  std::string name() const;
  /// "FILE: the last row has no line end and may be incomplete: left out", one for each part.
  /// Reads the end of each part.
  std::vector<std::string> notes() const;
  std::size_t axis_index(const std::string& axis) const;
  /// All columns that its CSV has, but `axis`.
  std::vector<Signal> signals(std::size_t axis) const;
  /// Of these columns, which are columns of cycles.
  std::vector<Signal> signals(std::size_t axis, std::span<const std::string> names) const;

  /// These columns of one axis; each of `names` as in cycles_*.csv. Throws Error at a name that the
  /// run does not have, and at a row that is no cycle: FILE:LINE:COLUMN: what, expected what.
  Columns read(std::size_t axis, std::span<const std::string> names, const TimeSpan& span = {}) const;

  /// In constant memory: calls `take` with blocks of the columns of these axes, for each axis in order of
  /// time.
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

// Reads a CSV of cycles (controller/cycle_record.h) row by row in constant memory. Columns are found by
// their names: a file of an older version may lack some, and one of a newer version may have more.

class CycleReader {
 public:
  /// Throws Error if the file cannot be read or is no CSV of cycles.
  explicit CycleReader(std::filesystem::path file);

  /// In the order of the file.
  const std::vector<std::string>& header() const { return header_; }
  /// Asks for one more column, by its name. False: the file does not have it. Throws Error at a
  /// name that no column of cycles has.
  bool add(std::string_view column);

  /// The columns asked for, and the name of the row's axis. False at the end of the file, and at a last
  /// line without its end, which a killed program leaves. Throws Error at a line that is no row:
  /// FILE:LINE:COLUMN: what, expected what.
  bool next(std::vector<double>& row, std::string_view& axis);

 private:
  struct Wanted {
    const controller::CycleColumn* column;
    std::size_t field;
    std::vector<std::string> words;
  };
  std::optional<std::size_t> field_of(std::string_view column) const;
  double value(const Wanted& wanted) const;

  config::CsvLines lines_;
  std::vector<std::string_view> fields_;
  std::vector<std::string> header_;
  std::vector<Wanted> wanted_;
  std::size_t axis_field_ = 0;
};

}  // namespace hystcan::runs
