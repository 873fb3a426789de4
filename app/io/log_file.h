// A log that grows while it is written: its lines stay in the file, whatever ends the program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace hystcan::app {

/// Unlike an OutputFile, it has its final name from the start. It holds whole lines only: if the disk is
/// full, the part of the last line that was written is removed again. Throws RunError if it cannot be
/// written.
class LogFile {
 public:
  /// Throws config::Error if the path is empty, or if the file exists and `overwrite` is false.
  LogFile(const std::filesystem::path& path, bool overwrite);
  ~LogFile();
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  /// Takes a line without its end and buffers it until there is enough to write, or until flush().
  void add(std::string_view line);
  void flush();
  /// Flushes and reports a last error of the disk. The destructor also closes, but reports nothing.
  void close();

 private:
  [[noreturn]] void fail(int error) const;

  std::filesystem::path path_;
  int descriptor_ = -1;
  bool regular_ = true;
  std::int64_t written_ = 0;  ///< bytes, whole lines
  std::string kept_;
};

}  // namespace hystcan::app
