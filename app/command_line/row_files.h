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

/// Returns true for a name that ends in .h5 or .hdf5.
bool has_hdf5_name(const std::filesystem::path& file);

class RowInput {
 public:
  virtual ~RowInput() = default;
  /// Fills the columns time_s and given with the next rows. Returns false at the end of the file. Throws
  /// Error with the place of an invalid row, of a value that is not finite, or of a decreasing time.
  virtual bool next(SampleBlock& block) = 0;
  /// The unit that the file gives for its column; empty if none.
  virtual std::string unit() const = 0;
  /// True if the file has the column time_s.
  virtual bool timed() const = 0;
  /// Returns one sentence for each omission at the end of the file.
  virtual std::vector<std::string> notes() const { return {}; }
  /// Returns the amount that was read so far, out of size(), for a progress bar.
  virtual std::uint64_t done() const = 0;
  virtual std::uint64_t size() const = 0;  ///< 0: unknown
};

/// Opens a CSV column or an HDF5 dataset named `column`, "input" or "output". `time_s` is optional; if it is
/// missing, the time is the row number. The contents decide the format. Throws Error.
std::unique_ptr<RowInput> open_rows(const std::filesystem::path& file, const std::string& column);

class RowOutput {
 public:
  virtual ~RowOutput() = default;
  virtual void write(const SampleBlock& block) = 0;
  /// Keeps the file; without this call, it is removed.
  virtual void commit() = 0;
};

/// Writes time_s, input, output. The format is HDF5 if the file name requires it, else CSV with the fewest
/// digits that restore the same bits.
std::unique_ptr<RowOutput> make_rows(const std::filesystem::path& file, const std::string& input_unit,
                                     const std::string& output_unit);

}  // namespace hystcan::app
