// Exports a recorded run, or a part of it, as one CSV or one HDF5 file.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runs/run.h"

namespace hystcan::storage {
class Hdf5Writer;
}  // namespace hystcan::storage

namespace hystcan::runs {

struct Selection {
  std::optional<std::string> axis;   ///< name of the axis; without it, the only axis (CSV) or all axes (HDF5)
  std::vector<std::string> signals;  ///< names of the columns to export; empty: all columns of the run
  TimeSpan span;
};

/// Returns the index of the axis with this name; without a name, the index of the run's only axis. Throws
/// Error if the name is unknown, or if a name is missing and the run has several axes.
std::size_t axis_of(const Run& run, const std::optional<std::string>& axis);
/// Returns the index of the selected axis; the indices of all axes if the selection names no axis. Throws
/// Error if the name is unknown or the run has no axes.
std::vector<std::size_t> axes_of(const Run& run, const Selection& selection);
/// Returns the names of the selected columns; the first name is `time_s`. Throws Error if the run lacks a
/// selected column.
std::vector<std::string> signals_of(const Run& run, std::size_t axis, const Selection& selection);

/// Throws Error if `rows`, the number of selected rows, is 0. The message gives the times of the run.
void require_rows(const Run& run, std::uint64_t rows);

/// Writes the rows of one axis as CSV: a comment line `# NAME_unit = "V"` for each column with a unit, the
/// header, and the rows. A number has the fewest digits from which the same double can be read back. States
/// and causes are words. A missing value is an empty field. Returns the number of rows. Throws Error if no
/// row is selected. Passes on exceptions of `write`.
std::uint64_t export_csv(const Run& run, const Selection& selection,
                         const std::function<void(std::string_view)>& write);

/// Writes an HDF5 file:
///
///   /                 attributes: version, host, started, ..., and run_json, the text of run.json
///   /AXIS/time_s      a group for each axis, a dataset for each column, with its unit; states and causes are
///                     enumerations
///   /config/FILE      the text of the configuration and of the files that it names
///
/// Exports all axes if the selection names no axis. Returns the number of rows. Throws Error if no row is
/// selected, and storage::Hdf5Error if writing fails. The caller closes the file.
std::uint64_t export_hdf5(const Run& run, const Selection& selection, storage::Hdf5Writer& file);

}  // namespace hystcan::runs
