// Truths as CSV, a row for each sample of each axis.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "twin/truth.h"

namespace hystcan::twin {

/// A disk that fills loses rows, not the run: close() says so.
class TruthLog {
 public:
  /// Throws std::runtime_error where the file can't be created.
  TruthLog(const std::filesystem::path& file, std::vector<std::string> axis_names);
  ~TruthLog();
  TruthLog(const TruthLog&) = delete;
  TruthLog& operator=(const TruthLog&) = delete;

  void write(const Truth& truth);
  /// Everything is on its way to the disk. Empty where all went well, else the reason.
  std::string close();

 private:
  std::filesystem::path path_;
  std::vector<std::string> axis_names_;
  std::FILE* file_;
  int error_ = 0;
};

}  // namespace hystcan::twin
