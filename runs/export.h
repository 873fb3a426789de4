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
  std::optional<std::string> axis;   ///< optional if the run has only one axis
  std::vector<std::string> signals;  ///< empty: all signals of the run
  TimeSpan span;
};

/// Returns the named axis, or the only axis of the run. Otherwise throws Error with the names of its axes.
std::size_t axis_of(const Run& run, const std::optional<std::string>& axis);
/// Returns the named axis; all axes if none is named. Throws Error.
std::vector<std::size_t> axes_of(const Run& run, const Selection& selection);
/// Returns the names of the selected columns, `time_s` first. Throws Error at an unknown name.
std::vector<std::string> signals_of(const Run& run, std::size_t axis, const Selection& selection);

/// Throws Error if `rows` is 0.
void require_rows(const Run& run, std::uint64_t rows);

/// Writes the rows of one axis: `# NAME_unit = "V"` for each unit, a header, and the rows. Numbers have the
/// fewest digits that restore the same bits; states and causes are words; a missing value is an empty field.
/// Returns the number of rows. Throws Error if no row is selected; passes on exceptions of `write`.
std::uint64_t export_csv(const Run& run, const Selection& selection,
                         const std::function<void(std::string_view)>& write);

/// Writes an HDF5 file:
///
///   /                 attributes: version, host, started, ..., and run_json, the whole run.json
///   /AXIS/time_s      a group for each axis, a dataset for each column, with its unit; states and causes are
///                     enumerations
///   /config/FILE      the text of the configuration and of the files that it names
///
/// Exports all axes if none is selected. Returns the number of rows. Throws Error if no row is selected, and
/// storage::Hdf5Error. The caller closes the file.
std::uint64_t export_hdf5(const Run& run, const Selection& selection, storage::Hdf5Writer& file);

}  // namespace hystcan::runs
