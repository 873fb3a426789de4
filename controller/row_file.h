// A file that grows by rows during a run. A full disk must not end the run.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

namespace hystcan::controller {

/// A full disk loses rows and does not stop the run; close() reports it.
class RowFile {
 public:
  /// Throws std::runtime_error where the file can't be created.
  RowFile(const std::filesystem::path& file, const char* first_lines);
  ~RowFile();
  RowFile(const RowFile&) = delete;
  RowFile& operator=(const RowFile&) = delete;

  void write(std::string_view row);
  /// Flushes and closes the file. Returns the reason where rows were lost; empty where none were.
  std::string close();

 private:
  std::filesystem::path path_;
  std::FILE* file_;
  int error_ = 0;
};

}  // namespace hystcan::controller
