#include "config/files/dataset_file.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

namespace hystcan::config {
namespace {

std::string taken_by_likeness(const LabCsvReader& reader, const DatasetColumns& columns) {
  if (!columns.by_likeness) return {};
  std::string text;
  const std::size_t first = columns.has_time() ? 0 : 1;
  for (std::size_t i = 0; i < columns.selected.size(); ++i) {
    const CsvColumn& column = reader.columns()[columns.selected[i]];
    text += fmt::format("{}{} from {}{}", i == 0 ? "" : ", ", column_meanings[i + first], column.title,
                        column.unit.empty() ? "" : fmt::format(" in {}", column.unit));
  }
  return text;
}

/// Unit of a comment, else of the header.
std::string unit_of(const LabCsvReader& reader, const char* name, const std::string& in_header) {
  const std::string in_comment = reader.comment(name);
  return in_comment.empty() ? in_header : in_comment;
}

/// Seconds of one unit of the time column beside a stated rate: it is the number of the sample, or it agrees.
double seconds_beside_rate(const LabCsvReader& reader, const DatasetColumns& columns, double rate_Hz,
                           const std::string& origin, double step) {
  const double unit_s = columns.time_unit_s.value_or(1.0);
  if (!columns.time_unit_s && step == std::round(step)) return 1.0 / rate_Hz;
  constexpr double rounded = 0.2;  // 0.0003 s at 3 kHz; agrees_with_rate() looks at all rows
  if (std::abs(unit_s * step * rate_Hz - 1.0) < rounded) return unit_s;
  throw Error(fmt::format("{}:{}: {} increases by {} s, expected {} s at {}, or the number of the sample",
                          reader.file().string(), reader.line_number(), columns.titles[0], unit_s * step,
                          1.0 / rate_Hz, origin));
}

/// Times that are rounded agree on average.
bool agrees_with_rate(const std::vector<double>& time_s, double rate_Hz) {
  constexpr double tolerance = 0.01;
  const double mean_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  return std::abs((time_s[1] - time_s[0]) * rate_Hz - 1.0) < tolerance ||
         std::abs(mean_s * rate_Hz - 1.0) < tolerance;
}

}  // namespace

DatasetFile load_dataset(const std::filesystem::path& file, const DatasetLayout& stated,
                         std::size_t most_rows) {
  LabCsvReader reader(file);
  DatasetLayout layout = stated;
  std::string origin_of_rate = layout.rate_Hz ? fmt::format("--rate {}", *layout.rate_Hz) : "";
  if (!layout.rate_Hz && reader.rate()) {
    layout.rate_Hz = reader.rate()->rate_Hz;
    origin_of_rate = fmt::format("\"{}\" (--rate says otherwise)", shortened(reader.rate()->line));
  }
  const DatasetColumns columns = dataset_columns(reader, layout);
  reader.select(columns.selected);
  DatasetFile loaded;
  loaded.taken = taken_by_likeness(reader, columns);
  if (!stated.rate_Hz && reader.rate() && !columns.time_unit_s)
    loaded.taken += fmt::format("{}{:g} Hz from \"{}\"", loaded.taken.empty() ? "" : ", ",
                                reader.rate()->rate_Hz, shortened(reader.rate()->line));
  identification::Dataset& dataset = loaded.dataset;
  dataset.input_unit = unit_of(reader, "input_unit", columns.input_unit);
  dataset.output_unit =
      layout.output_scale ? columns.output_unit : unit_of(reader, "output_unit", columns.output_unit);
  const std::size_t first = columns.has_time() ? 1 : 0;
  double seconds = columns.seconds;
  std::vector<double> row;
  while (reader.next(row)) {
    const double t = columns.has_time() ? row[0] : static_cast<double>(dataset.size());
    if (layout.rate_Hz && columns.has_time() && dataset.size() == 1) {
      const double before = dataset.time_s.front() / seconds;
      seconds = seconds_beside_rate(reader, columns, *layout.rate_Hz, origin_of_rate, t - before);
      dataset.time_s.front() = seconds * before;
    }
    const double time_s = seconds * t;
    if (!dataset.time_s.empty() && time_s <= dataset.time_s.back())
      throw Error(fmt::format("{}:{}: {} is {} after {}, expected time to increase", file.string(),
                              reader.line_number(), columns.titles[0], t, dataset.time_s.back() / seconds));
    if (dataset.size() == most_rows)
      throw Error(fmt::format("{}:{}:1: one more row, expected at most {} rows", file.string(),
                              reader.line_number(), most_rows));
    loaded.last_row_left_out = reader.ends_in_mid_line();
    if (loaded.last_row_left_out) break;
    dataset.time_s.push_back(time_s);
    dataset.input.push_back(columns.input_scale * row[first]);
    dataset.output.push_back(columns.output_scale * row[first + 1]);
    for (const double value : {time_s, dataset.input.back(), dataset.output.back()})
      if (!(std::abs(value) <= identification::largest_value))
        throw Error(fmt::format("{}:{}: a value is {}, expected at most {} in magnitude", file.string(),
                                reader.line_number(), value, identification::largest_value));
  }
  const bool counts_samples = layout.rate_Hz && seconds == 1.0 / *layout.rate_Hz;
  if (layout.rate_Hz && !counts_samples && dataset.size() > 1 &&
      !agrees_with_rate(dataset.time_s, *layout.rate_Hz))
    throw Error(fmt::format("{}: {} contradicts the rate, expected {} s from row to row at {}", file.string(),
                            columns.titles[0], 1.0 / *layout.rate_Hz, origin_of_rate));
  return loaded;
}

}  // namespace hystcan::config
