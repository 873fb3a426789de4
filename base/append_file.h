// A file that grows by whole lines while a program runs: its lines stay in it, whatever ends the program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

namespace hystcan {

/// Has its final name from the start. If the disk is full, the part of a line that was written is removed
/// again, and later lines are dropped: the first error stays.
class AppendFile {
 public:
  enum class Existing : std::uint8_t { refuse, replace };

  /// Throws std::system_error, with the name of the file in its text, if the file cannot be made; of
  /// std::errc::file_exists where it exists and is to be kept. A device or a pipe is written to as it is.
  AppendFile(std::filesystem::path path, Existing existing);
  ~AppendFile();  ///< writes what is left, and reports nothing
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /// Takes whole lines with their ends. Keeps them until there is enough to write, or until flush().
  void add(std::string_view lines);
  /// Passes all lines to the system: they survive the end of this process.
  std::error_code flush();
  /// Flushes; the lines survive a loss of power too.
  std::error_code sync();
  /// Flushes and closes.
  std::error_code close();

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t written_bytes() const { return written_; }
  std::error_code error() const { return error_; }
  /// "FILE: cannot be written: REASON"; empty if there is no error.
  std::string error_text() const;
  /// False if the file was removed, or another one has its name.
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
