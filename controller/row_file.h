// A file that grows by rows while something runs, which must not end because a disk is full.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

namespace hystcan::controller {

/// A disk that fills loses rows, not the run: close() says so.
class RowFile {
 public:
  /// Throws std::runtime_error where the file can't be created.
  RowFile(const std::filesystem::path& file, const char* header);
  ~RowFile();
  RowFile(const RowFile&) = delete;
  RowFile& operator=(const RowFile&) = delete;

  void write(std::string_view row);
  /// Everything is on its way to the disk. Empty where all went well, else the reason.
  std::string close();

 private:
  std::filesystem::path path_;
  std::FILE* file_;
  int error_ = 0;
};

}  // namespace hystcan::controller
