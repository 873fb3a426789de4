// A file to which a program appends whole lines: they stay in the file however the program ends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

namespace hystcan {

/// An output file that has its final name from the start. If the disk is full, an incompletely written line
/// is removed again, and later lines are dropped; error() keeps the first error.
class AppendFile {
 public:
  enum class Existing : std::uint8_t { refuse, replace };

  /// Throws std::system_error with the file name if the file cannot be created; the error is
  /// std::errc::file_exists if the file exists and `existing` is `refuse`. Writes to a device or a pipe
  /// without replacing it.
  AppendFile(std::filesystem::path path, Existing existing);
  ~AppendFile();  ///< writes the remaining lines, and reports no error
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /// Adds whole lines with their ends. Keeps them until there is enough to write, or until flush().
  void add(std::string_view lines);
  /// Passes all lines to the system: they survive the end of this process.
  std::error_code flush();
  /// Flushes, so that the lines also survive a loss of power.
  std::error_code sync();
  /// Flushes and closes.
  std::error_code close();

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t written_bytes() const { return written_; }
  std::error_code error() const { return error_; }
  /// "FILE: cannot be written: REASON"; empty if there is no error.
  std::string error_text() const;
  /// False if the file was removed, or if another file now has its name.
  bool is_in_place() const;

 private:
  void write(std::string_view lines);

  std::filesystem::path path_;
  int descriptor_ = -1;
  bool is_regular_ = true;
  std::uint64_t written_ = 0;  ///< bytes, whole lines
  std::string kept_;           ///< lines until there is enough to write; its memory does not grow
  std::error_code error_;
};

}  // namespace hystcan
