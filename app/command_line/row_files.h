// The files of `simulate`: a signal to read and the rows to write, in blocks, as CSV or HDF5.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hystcan::app {

/// Columns of equal length.
struct SampleBlock {
  static constexpr std::size_t most = 4096;  ///< rows
  std::vector<double> time_s, given, input, output;
};

/// True for a name that ends in .h5 or .hdf5.
bool has_hdf5_name(const std::filesystem::path& file);

class RowInput {
 public:
  virtual ~RowInput() = default;
  /// Fills time_s and given. False at the end. Throws Error at a value that is not finite, at a row that is
  /// none, and where time decreases, with the place.
  virtual bool next(SampleBlock& block) = 0;
  /// That the file states for its column; empty: none.
  virtual std::string unit() const = 0;
  /// The file has the column time_s.
  virtual bool timed() const = 0;
  /// What was left out at the end, a sentence each.
  virtual std::vector<std::string> notes() const { return {}; }
  /// What was read of `size()`, for a progress bar.
  virtual std::uint64_t done() const = 0;
  virtual std::uint64_t size() const = 0;  ///< 0: unknown
};

/// `column`: "input" or "output", a CSV column or an HDF5 dataset beside `time_s`, which may be left out:
/// then it is the number of the row. The contents tell which format it is. Throws Error.
std::unique_ptr<RowInput> open_rows(const std::filesystem::path& file, const std::string& column);

class RowOutput {
 public:
  virtual ~RowOutput() = default;
  virtual void write(const SampleBlock& block) = 0;
  /// Without it no file remains.
  virtual void commit() = 0;
};

/// time_s, input, output. HDF5 if its name says so, else CSV with the shortest digits that read back to the
/// same bits.
std::unique_ptr<RowOutput> make_rows(const std::filesystem::path& file, const std::string& input_unit,
                                     const std::string& output_unit);

}  // namespace hystcan::app
