#include "config/files/setpoint_file.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/text.h"
#include "config/files/csv.h"

namespace hystcan::config {
namespace {

/// A running controller reads this file too, so it must not wait for a pipe.
std::string text_of_setpoint(const std::filesystem::path& file) {
  constexpr std::size_t largest = std::size_t{64} << 20U;  // 64 MiB
  try {
    return read_regular_file(file, largest);
  } catch (const FileError& error) {
    throw Error(fmt::format("{}: cannot be read: {}, expected a CSV file", file.string(), error.what()));
  }
}

}  // namespace

controller::MonotoneCubic load_setpoint(const std::filesystem::path& file) {
  CsvReader reader(file, text_of_setpoint(file), {"time_s", "position_um"});
  std::vector<double> time_s;
  std::vector<double> position_um;
  std::vector<double> row;
  while (reader.next(row)) {
    if (!time_s.empty() && row[0] <= time_s.back())
      throw Error(fmt::format("{}:{}:1: time_s is {} after {}, expected time to increase", file.string(),
                              reader.line_number(), row[0], time_s.back()));
    time_s.push_back(row[0]);
    position_um.push_back(row[1]);
  }
  if (time_s.size() < 2)
    throw Error(fmt::format("{}:{}:1: a reference of {}, expected two or more", file.string(),
                            reader.line_number(), counted(time_s.size(), "row")));
  return {std::move(time_s), std::move(position_um)};
}

}  // namespace hystcan::config
