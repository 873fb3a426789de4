// Writes the truth of a twin as CSV, one row for each sample of each axis.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "controller/row_file.h"
#include "twin/truth.h"

namespace hystcan::app {

class TruthLog {
 public:
  /// Throws std::runtime_error if the file cannot be created.
  TruthLog(const std::filesystem::path& file, std::vector<std::string> axis_names);

  void write(const twin::Truth& truth);
  /// See RowFile::close().
  std::string close() { return rows_.close(); }

 private:
  std::vector<std::string> axis_names_;
  controller::RowFile rows_;
};

}  // namespace hystcan::app
