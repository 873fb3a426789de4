// Columns in HDF5 files (https://www.hdfgroup.org), written by h5py in its own process
// (python/hystcan/hdf5.py).
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

/// A file that can't be written: "FILE: PROBLEM".
struct Hdf5Error : PlacedError {
  using PlacedError::PlacedError;
};

inline constexpr std::string_view hdf5_package = "python3-h5py";

/// A one-dimensional dataset: float64, or bytes if its values have words.
struct Column {
  std::string name;
  std::string unit;                ///< attribute `unit`; empty if none
  std::vector<std::string> words;  ///< an enumeration of the values 0, 1, ...; empty: numbers
};

/// Writes a file, replacing an existing one. Each call throws Hdf5Error if the file can't be written; an
/// error may be reported by a later call, at the latest by close().
class Hdf5Writer {
 public:
  /// Rows per stored and compressed block; append() is fastest with blocks of this size.
  static constexpr std::size_t chunk_rows = 65'536;

  explicit Hdf5Writer(std::filesystem::path file);

  /// Adds a group with empty columns; the group "/" is the root of the file. Returns the table's number for
  /// append(). `is_deflated`: compresses without loss (HDF5 filters shuffle and deflate).
  std::size_t add_table(const std::string& group, const std::vector<Column>& columns, bool is_deflated);
  /// Appends columns in the order of the table, all of the same length.
  void append(std::size_t table, std::span<const std::vector<double>> columns);
  /// Sets attributes of an existing group or dataset.
  void set(const std::string& object, const std::string& name, const std::string& text);
  void set(const std::string& object, const std::string& name, double value);
  /// Adds a text as a dataset.
  void add_text(const std::string& path, const std::string& text);
  /// Writes everything. Without this call the file is incomplete.
  void close();

 private:
  void send(const nlohmann::json& message);
  void send_bytes(std::string_view bytes);

  std::filesystem::path path_;
  PythonModule python_;
  std::size_t tables_ = 0;
};

}  // namespace hystcan::storage
