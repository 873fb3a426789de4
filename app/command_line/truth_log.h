// Writes the true states of a twin as CSV, one row for each sample of each axis.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/append_file.h"
#include "twin/twin.h"

namespace hystcan::app {

class TruthLog {
 public:
  /// Creates the file; replaces an existing one. Throws std::system_error if the file cannot be created.
  TruthLog(const std::filesystem::path& file, std::vector<std::string> axis_names);

  void write(const twin::Truth& truth);
  /// Closes the file. Returns the reason if rows could not be written.
  std::optional<std::string> close();

 private:
  std::vector<std::string> axis_names_;
  AppendFile rows_;
};

}  // namespace hystcan::app
