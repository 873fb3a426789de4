#include "config/record_file.h"

#include <fmt/format.h>

#include "config/csv.h"

namespace hystcan::config {

RecordFile load_record(const std::filesystem::path& file) {
  CsvReader reader(file, {"time_s", "input", "output"});
  RecordFile loaded;
  identification::Record& record = loaded.record;
  record.input_unit = reader.comment("input_unit");
  record.output_unit = reader.comment("output_unit");
  std::vector<double> row;
  while (reader.next(row)) {
    if (!record.time_s.empty() && row[0] <= record.time_s.back())
      throw Error(fmt::format("{}:{}: time_s is {} after {}, expected time to increase", file.string(),
                              reader.line_number(), row[0], record.time_s.back()));
    loaded.last_row_left_out = reader.ends_in_mid_line();
    if (loaded.last_row_left_out) break;
    record.time_s.push_back(row[0]);
    record.input.push_back(row[1]);
    record.output.push_back(row[2]);
  }
  return loaded;
}

}  // namespace hystcan::config
