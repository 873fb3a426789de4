#include "app/stage/record_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "base/error.h"
#include "base/text.h"
#include "identification/suspect_rows.h"

namespace hystcan::app {
namespace {

using identification::Dataset;
using identification::SensorEnd;
using identification::SuspectRow;

std::string text_of_row(const SuspectRow& suspect, const Dataset& dataset) {
  return fmt::format("{} {:.6g} {} instead of about {:.6g} in row {} ({:.6g} s)",
                     suspect.of_input ? "input" : "output", suspect.value,
                     suspect.of_input ? dataset.input_unit : dataset.output_unit, suspect.usual,
                     suspect.row + 1, dataset.time_s[suspect.row]);
}

std::string text_of_rows(const std::vector<SuspectRow>& suspects, const Dataset& dataset) {
  constexpr std::size_t most_named = 4;
  std::string rows;
  for (std::size_t i = 0; i < std::min(suspects.size(), most_named); ++i)
    rows += (i > 0 ? ", " : "") + text_of_row(suspects[i], dataset);
  if (suspects.size() > most_named) rows += fmt::format(" and {} more", suspects.size() - most_named);
  return rows + ": a stage cannot move like this";
}

std::string text_of_end(const SensorEnd& end, const Dataset& dataset) {
  return fmt::format(
      "the output stays at {:.6g} {}, its {} value, in {} ({:.2g} % of all) while the input moves: "
      "the sensor or its recorder is at its limit",
      end.value, dataset.output_unit, end.is_upper ? "highest" : "lowest", counted(end.rows, "row"),
      100.0 * static_cast<double>(end.rows) / static_cast<double>(dataset.size()));
}

}  // namespace

std::vector<RecordWarning> leave_out_suspects(const std::filesystem::path& file, Dataset& dataset) {
  std::vector<RecordWarning> warnings;
  const std::vector<SuspectRow> suspects = identification::suspect_rows(dataset);
  if (!suspects.empty()) {
    warnings.push_back({fmt::format("{}: {}", file.string(), text_of_rows(suspects, dataset)),
                        suspects.size() > 1 ? "these rows are left out" : "this row is left out"});
    dataset = identification::without_rows(dataset, suspects);
  }
  for (const SensorEnd& end : identification::sensor_ends(dataset))
    warnings.push_back({fmt::format("{}: {}", file.string(), text_of_end(end, dataset)),
                        "all rows are used, although this output is not the position of the stage"});
  return warnings;
}

void refuse_same_rows(const std::filesystem::path& file, const Dataset& dataset,
                      const std::filesystem::path& other_file, const Dataset& other) {
  if (identification::has_same_rows(dataset, other))
    throw Error(file,
                fmt::format("has the same rows as {}: both files hold the same session", other_file.string()),
                {.remedy = "leave out one of the two files"});
}

void refuse_same_rows(const std::vector<std::filesystem::path>& files, const std::vector<Dataset>& datasets) {
  for (std::size_t i = 0; i < datasets.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) refuse_same_rows(files[i], datasets[i], files[j], datasets[j]);
}

}  // namespace hystcan::app
