// The files of `hystcan simulate`: the input signal and the resulting rows. Both are CSV or HDF5 and are
// processed in blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hystcan::app {

/// A block of rows. All columns in use have the same length.
struct SampleBlock {
  static constexpr std::size_t most = 4096;  ///< maximum number of rows
  std::vector<double> time_s, given, input, output;
};

/// Returns true if the file name ends in .h5 or .hdf5.
bool has_hdf5_name(const std::filesystem::path& file);

class RowInput {
 public:
  virtual ~RowInput() = default;
  /// Fills the columns `time_s` and `given` (the signal that was read) of `block` with the next rows. Returns
  /// false at the end of the file. Throws Error with the row number if a row is invalid, a value is not
  /// finite, or the time decreases.
  virtual bool next(SampleBlock& block) = 0;
  /// Returns the unit of the signal, as the file states it; empty if the file states none.
  virtual std::string unit() const = 0;
  /// Returns true if the file has the column time_s.
  virtual bool timed() const = 0;
  /// Returns one sentence for each part that was ignored, such as an incomplete last row. Call this after
  /// next() returned false.
  virtual std::vector<std::string> notes() const { return {}; }
  /// Returns how much of size() was read so far, for a progress bar.
  virtual std::uint64_t done() const = 0;
  virtual std::uint64_t size() const = 0;  ///< total amount to read, in the unit of done(); 0: unknown
};

/// Opens the CSV column or HDF5 dataset named `column` ("input" or "output"). The file's contents determine
/// the format, not its name. If the column `time_s` is missing, the row number is used as the time. Throws
/// Error if the file cannot be read.
std::unique_ptr<RowInput> open_rows(const std::filesystem::path& file, const std::string& column);

class RowOutput {
 public:
  virtual ~RowOutput() = default;
  virtual void write(const SampleBlock& block) = 0;
  /// Keeps the written file. If commit() was not called, the destructor removes the file.
  virtual void commit() = 0;
};

/// Creates a file with the columns time_s, input and output. The format is HDF5 if the file name ends in .h5
/// or .hdf5, otherwise CSV. Numbers in CSV have the fewest digits from which the same double can be read
/// again.
std::unique_ptr<RowOutput> make_rows(const std::filesystem::path& file, const std::string& input_unit,
                                     const std::string& output_unit);

}  // namespace hystcan::app
