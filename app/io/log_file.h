// A log that grows while it is written: what is in it stays, whatever ends the program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace hystcan::app {

/// Unlike OutputFile it stands at its place from the start. Whole lines only: where the disk is full, what is
/// written of the line that no longer fits is taken back. Throws RunError where it can't be written.
class LogFile {
 public:
  /// Throws config::Error where the path is empty, or a file is there and `overwrite` is not set.
  LogFile(const std::filesystem::path& path, bool overwrite);
  ~LogFile();
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  /// `line` without its end. Kept back until there is enough to write, or flush().
  void add(std::string_view line);
  void flush();
  /// Flushes, and tells what the disk has to say at last. Without it the destructor closes, in silence.
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
