// A recorded run, or a part of it, as one HDF5 file:
//
//   /                 attributes: version, host, started, ..., and run_json, the whole run.json
//   /AXIS/time_s      a group for each axis, a dataset for each column, with its unit; states and causes are enumerations
//   /config/FILE      the text of the configuration and of the files that it names
#pragma once

#include <cstdint>
#include <string>

#include "runs/export.h"
#include "runs/run.h"

namespace hystcan::storage {
class Hdf5Writer;
}  // namespace hystcan::storage

namespace hystcan::runs {

/// Without a selected axis, all axes. Returns the number of rows. Throws Error if none is selected, and
/// storage::Hdf5Error. The caller closes the file.
std::uint64_t export_hdf5(const Run& run, const Selection& selection, storage::Hdf5Writer& file);

}  // namespace hystcan::runs
