#include "app/record_input.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/config.h"
#include "config/record_file.h"

namespace hystcan::app {
namespace {

using identification::Record;

/// What a record, and what the command line calls a unit; what it is where neither tells.
struct UnitOf {
  const char* name;
  const char* option;
  const char* assumed;
};
constexpr UnitOf input_unit{"input_unit", "--input-unit", "V"};
constexpr UnitOf output_unit{"output_unit", "--output-unit", "um"};

void keep_stretch(Record& record, const RecordInput& input) {
  const auto first = std::ranges::lower_bound(record.time_s, input.from_s.value_or(record.time_s.front()));
  const auto last = std::ranges::upper_bound(record.time_s, input.to_s.value_or(record.time_s.back()));
  const auto begin = first - record.time_s.begin(), end = std::max(last, first) - record.time_s.begin();
  for (auto* column : {&record.time_s, &record.input, &record.output}) {
    column->erase(column->begin() + end, column->end());
    column->erase(column->begin(), column->begin() + begin);
  }
}

void settle(std::string& unit, const std::string& asked, const UnitOf& of,
            const std::filesystem::path& file) {
  if (!asked.empty()) {
    refuse_other_unit(file, of.name, unit, asked);
    unit = asked;
  }
  if (unit.empty()) {
    unit = of.assumed;
    fmt::print(stderr, "hystcan: {}: {} is not told, {} assumed\n", file.string(), of.option, of.assumed);
  }
}

Record load(const std::filesystem::path& file, const RecordInput& input) {
  config::RecordFile loaded = config::load_record(file);
  Record record = std::move(loaded.record);
  if (loaded.last_row_left_out)
    fmt::print(stderr, "hystcan: {}: no line end after the last row, which may have been cut: left out\n",
               file.string());
  if (record.size() > 0) keep_stretch(record, input);
  if (record.size() == 0)
    throw config::Error(fmt::format("{}: no rows{}, expected a record", file.string(),
                                    input.from_s || input.to_s ? " between --from and --to" : ""));
  settle(record.input_unit, input.input_unit, input_unit, file);
  settle(record.output_unit, input.output_unit, output_unit, file);
  return record;
}

}  // namespace

void refuse_other_unit(const std::filesystem::path& file, const char* name, const std::string& told,
                       const std::string& expected, const char* whose) {
  if (!told.empty() && told != expected)
    throw config::Error(fmt::format("{}: it says {} = \"{}\", expected \"{}\"{}", file.string(), name, told,
                                    expected, whose));
}

void add_record_options(CLI::App& command, RecordInput& input) {
  command.add_option("--from", input.from_s, "leave out what was before this time_s");
  command.add_option("--to", input.to_s, "leave out what came after this time_s");
  command.add_option(input_unit.option, input.input_unit,
                     "of the input, where the record does not tell: V, A");
  command.add_option(output_unit.option, input.output_unit,
                     "of the output, where the record does not tell: um");
}

std::vector<Record> load_records(const std::vector<std::filesystem::path>& files, const RecordInput& input) {
  std::vector<Record> records;
  for (const auto& file : files) {
    records.push_back(load(file, input));
    const Record &first = records.front(), &last = records.back();
    if (last.input_unit != first.input_unit || last.output_unit != first.output_unit)
      throw config::Error(fmt::format("{}: {} to {}, expected {} to {} as in {}", file.string(),
                                      last.input_unit, last.output_unit, first.input_unit, first.output_unit,
                                      files.front().string()));
  }
  return records;
}

}  // namespace hystcan::app
