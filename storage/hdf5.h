// Writes tables of columns to an HDF5 file (https://www.hdfgroup.org). The library h5py writes the file, in a
// Python process that runs python/hystcan/hdf5.py.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/python_module.h"

namespace hystcan::storage {

/// Thrown if the file cannot be written. The message is "FILE: PROBLEM".
struct Hdf5Error : PlacedError {
  using PlacedError::PlacedError;
};

inline constexpr std::string_view hdf5_package = "python3-h5py";

/// A column of a table, stored as a one-dimensional HDF5 dataset. The values are float64; if `words` is not
/// empty, they are bytes.
struct Column {
  std::string name;
  std::string unit;                ///< stored as the attribute `unit`; empty if the column has no unit
  std::vector<std::string> words;  ///< names of the values 0, 1, ... of an enumeration; empty for numbers
};

/// Writes an HDF5 file and replaces an existing file. Each function throws Hdf5Error if the file cannot be
/// written. Some errors appear late: a later call throws them, at the latest close().
class Hdf5Writer {
 public:
  /// Number of rows that are stored and compressed together. append() is fastest if its columns have this
  /// length.
  static constexpr std::size_t chunk_rows = 65'536;

  explicit Hdf5Writer(std::filesystem::path file);

  /// Adds an HDF5 group with empty columns to the file; "/" is the root group. Returns the number of the
  /// table, which append() needs. `is_deflated`: compresses the columns without loss (HDF5 filters shuffle
  /// and deflate).
  std::size_t add_table(const std::string& group, const std::vector<Column>& columns, bool is_deflated);
  /// Appends rows to a table. `columns` has the order of the columns in add_table(); all its columns have the
  /// same length.
  void append(std::size_t table, std::span<const std::vector<double>> columns);
  /// Sets an attribute, `name`, of the existing group or dataset `object`.
  void set(const std::string& object, const std::string& name, const std::string& text);
  void set(const std::string& object, const std::string& name, double value);
  /// Adds a dataset at `path` that contains a text.
  void add_text(const std::string& path, const std::string& text);
  /// Writes all remaining data and closes the file. Without this call, the file is incomplete.
  void close();

 private:
  void send(const nlohmann::json& message);
  void send_bytes(std::string_view bytes);

  std::filesystem::path path_;
  PythonModule python_;
  std::size_t tables_ = 0;
};

}  // namespace hystcan::storage
