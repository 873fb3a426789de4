#include "config/files/setpoint_file.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "config/files/csv.h"

namespace hystcan::config {

controller::MonotoneCubic load_setpoint(const std::filesystem::path& file) {
  CsvReader reader(file, {"time_s", "position_um"});
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
    throw Error(fmt::format("{}:{}:1: a reference of {} rows, expected two or more", file.string(),
                            reader.line_number(), time_s.size()));
  return {std::move(time_s), std::move(position_um)};
}

}  // namespace hystcan::config
