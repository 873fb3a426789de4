// Truths of a twin as CSV, a row for each sample of each axis.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "controller/row_file.h"
#include "twin/truth.h"

namespace hystcan::app {

class TruthLog {
 public:
  /// Throws std::runtime_error where the file can't be created.
  TruthLog(const std::filesystem::path& file, std::vector<std::string> axis_names);

  void write(const twin::Truth& truth);
  /// As RowFile::close().
  std::string close() { return rows_.close(); }

 private:
  std::vector<std::string> axis_names_;
  controller::RowFile rows_;
};

}  // namespace hystcan::app
