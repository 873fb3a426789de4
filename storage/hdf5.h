// Columns in HDF5 files (https://www.hdfgroup.org), the default file format.
//
// libhdf5 brings three dozen libraries with it. They are loaded when the first file is made or opened, and
// never in a process that controls: the code that needs them is a library of its own, `hystcan_hdf5.so`
// (storage/hdf5/).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace hystcan::storage {

/// A file that cannot be made, read or written: "FILE: what, expected what".
class Hdf5Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A one-dimensional dataset: float64, or a byte where its values have words.
struct Column {
  std::string name;
  std::string unit;                ///< attribute `unit`; empty: none
  std::vector<std::string> words;  ///< an enumeration of the values 0, 1, ...; empty: numbers
};

class Hdf5Writer {
 public:
  virtual ~Hdf5Writer() = default;
  /// A group of columns of equal length, which grow; "/" is the file itself. Returns the number of the table.
  /// `is_deflated`: bytes shuffled and compressed, without loss.
  virtual std::size_t add_table(const std::string& group, const std::vector<Column>& columns,
                                bool is_deflated) = 0;
  /// Columns in the order of the table, all of the same length. Throws Hdf5Error.
  virtual void append(std::size_t table, std::span<const std::vector<double>> columns) = 0;
  /// Attributes of a group or of a dataset that exists.
  virtual void set(const std::string& object, const std::string& name, const std::string& text) = 0;
  virtual void set(const std::string& object, const std::string& name, double value) = 0;
  /// A text as a dataset.
  virtual void add_text(const std::string& path, const std::string& text) = 0;
  /// Writes all. Throws Hdf5Error. Without it the file is incomplete.
  virtual void close() = 0;
};

class Hdf5Reader {
 public:
  virtual ~Hdf5Reader() = default;
  virtual bool has(const std::string& dataset) const = 0;
  /// Length of a one-dimensional dataset of numbers. Throws Hdf5Error if it is none.
  virtual std::uint64_t rows(const std::string& dataset) const = 0;
  /// Reads values from..from+into.size() of the dataset, converted to double.
  virtual void read(const std::string& dataset, std::uint64_t from, std::span<double> into) const = 0;
  /// A text attribute of a dataset or group.
  virtual std::optional<std::string> text(const std::string& object, const std::string& name) const = 0;
};

/// Whether the library is there; does not load it.
bool has_hdf5();
/// Replaces the file. Throws Hdf5Error.
std::unique_ptr<Hdf5Writer> create_hdf5(const std::filesystem::path& file);
/// Throws Hdf5Error.
std::unique_ptr<Hdf5Reader> open_hdf5(const std::filesystem::path& file);

/// What the library hystcan_hdf5.so gives: its function `hystcan_hdf5`.
struct Hdf5Library {
  std::unique_ptr<Hdf5Writer> (*create)(const std::filesystem::path& file);
  std::unique_ptr<Hdf5Reader> (*open)(const std::filesystem::path& file);
};
using Hdf5Entry = const Hdf5Library*();

}  // namespace hystcan::storage
