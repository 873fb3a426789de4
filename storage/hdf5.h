// Columns in HDF5 files (https://www.hdfgroup.org), which h5py writes in a process of its own
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

/// A file that cannot be written: "FILE: what".
struct Hdf5Error : PlacedError {
  using PlacedError::PlacedError;
};

inline constexpr std::string_view hdf5_package = "python3-h5py";

/// A one-dimensional dataset: float64, or a byte where its values have words.
struct Column {
  std::string name;
  std::string unit;                ///< attribute `unit`; empty: none
  std::vector<std::string> words;  ///< an enumeration of the values 0, 1, ...; empty: numbers
};

/// Replaces a file. Each call throws Hdf5Error if the file cannot be written; what is wrong may arrive with a
/// later call, at the latest with close().
class Hdf5Writer {
 public:
  /// Columns are stored, compressed and best appended in blocks of this size.
  static constexpr std::size_t chunk_rows = 65'536;

  explicit Hdf5Writer(std::filesystem::path file);

  /// A group of columns of equal length, which grow; "/" is the file itself. Returns the number of the table.
  /// `is_deflated`: bytes shuffled and compressed, without loss.
  std::size_t add_table(const std::string& group, const std::vector<Column>& columns, bool is_deflated);
  /// Columns in the order of the table, all of the same length.
  void append(std::size_t table, std::span<const std::vector<double>> columns);
  /// Attributes of a group or of a dataset that exists.
  void set(const std::string& object, const std::string& name, const std::string& text);
  void set(const std::string& object, const std::string& name, double value);
  /// A text as a dataset.
  void add_text(const std::string& path, const std::string& text);
  /// Writes all. Without it the file is incomplete.
  void close();

 private:
  void send(const nlohmann::json& message);
  void send_bytes(std::string_view bytes);

  std::filesystem::path path_;
  PythonModule python_;
  std::size_t tables_ = 0;
};

}  // namespace hystcan::storage
