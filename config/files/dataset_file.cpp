#include "config/files/dataset_file.h"

#include <fmt/format.h>

#include "config/files/csv.h"

namespace hystcan::config {

DatasetFile load_dataset(const std::filesystem::path& file, std::size_t most_rows) {
  CsvReader reader(file, {"time_s", "input", "output"});
  DatasetFile loaded;
  identification::Dataset& dataset = loaded.dataset;
  dataset.input_unit = reader.comment("input_unit");
  dataset.output_unit = reader.comment("output_unit");
  std::vector<double> row;
  while (reader.next(row)) {
    if (!dataset.time_s.empty() && row[0] <= dataset.time_s.back())
      throw Error(fmt::format("{}:{}: time_s is {} after {}, expected time to increase", file.string(),
                              reader.line_number(), row[0], dataset.time_s.back()));
    if (dataset.size() == most_rows)
      throw Error(fmt::format("{}:{}:1: one more row, expected at most {} rows", file.string(),
                              reader.line_number(), most_rows));
    loaded.last_row_left_out = reader.ends_in_mid_line();
    if (loaded.last_row_left_out) break;
    dataset.time_s.push_back(row[0]);
    dataset.input.push_back(row[1]);
    dataset.output.push_back(row[2]);
  }
  return loaded;
}

}  // namespace hystcan::config
