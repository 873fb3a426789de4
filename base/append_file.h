// An output file to which a program appends whole lines. Lines that reached the file stay there, even if the
// program is killed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

namespace hystcan {

/// An output file that has its final name from the start, unlike OutputFile. If the disk is full, the class
/// removes the incomplete last line from the file and drops all later lines. error() returns the first error.
class AppendFile {
 public:
  enum class Existing : std::uint8_t { refuse, replace };

  /// Opens the file. Throws std::system_error, with the file name, if the file cannot be created. If
  /// `existing` is `refuse` and the file exists, the error is std::errc::file_exists. A device or a pipe is
  /// opened for writing and is not replaced.
  AppendFile(std::filesystem::path path, Existing existing);
  ~AppendFile();  ///< writes the lines in memory to the file; ignores errors
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /// Adds one or more whole lines, each with its line feed. The lines stay in memory until 64 KiB are full,
  /// or until flush().
  void add(std::string_view lines);
  /// Writes all lines in memory to the file. Then the lines survive a crash of this process, but not a loss
  /// of power.
  std::error_code flush();
  /// Calls flush(), then writes the file to the disk: the lines also survive a loss of power.
  std::error_code sync();
  /// Calls flush() and closes the file.
  std::error_code close();

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t written_bytes() const { return written_; }
  std::error_code error() const { return error_; }
  /// Returns "FILE: cannot be written: REASON"; returns an empty text if there was no error.
  std::string error_text() const;
  /// Returns false if the file was removed or renamed, or if another file now has its name.
  bool is_in_place() const;

 private:
  void write(std::string_view lines);

  std::filesystem::path path_;
  int descriptor_ = -1;
  bool is_regular_ = true;
  std::uint64_t written_ = 0;  ///< number of bytes in the file, whole lines only
  /// Lines that are not yet written. The memory of the text never grows, because it holds at most 64 KiB.
  std::string kept_;
  std::error_code error_;
};

}  // namespace hystcan
