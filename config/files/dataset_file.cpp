#include "config/files/dataset_file.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "base/text.h"
#include "config/files/csv.h"
#include "config/files/dataset_columns.h"
#include "config/files/lab_csv.h"
#include "config/files/record_words.h"

namespace hystcan::config {
namespace {

/// Returns the base unit of a column, and the factor that converts the column's values to it. The unit in the
/// comment `# NAME = ...` has priority over the unit in the header.
std::pair<std::string, double> unit_of(const LabCsvReader& reader, const char* name,
                                       const std::string& in_header, double header_scale) {
  const std::string in_comment = reader.comment(name);
  if (in_comment.empty()) return {in_header, header_scale};
  const UnitWord* unit = find_unit(in_comment);
  if (unit == nullptr) return {in_comment, 1.0};
  return {std::string(unit->base), unit->factor};
}

/// A unit in which a clock may count the time since 1970. In a column without a unit, counts from `first` to
/// `last` (the years 2008 to 2036) with steps up to `longest_step` (one second) are times since 1970. They
/// could also be in the next smaller unit, from a clock that started at 0. But such a clock reaches `first`
/// only after 13 days.
struct Epoch {
  double first, last, longest_step, unit_s;
  const char* name;
};
constexpr std::array<Epoch, 3> epochs{{{1.2e12, 2.1e12, 1e3, 1e-3, "milliseconds"},
                                       {1.2e15, 2.1e15, 1e6, 1e-6, "microseconds"},
                                       {1.2e18, 2.1e18, 1e9, 1e-9, "nanoseconds"}}};

/// Returns true if the first step of the times, or their mean step, agrees with the rate within 1 %. The
/// times in the file may be rounded.
bool agrees_with_rate(const std::vector<double>& time_s, double rate_Hz) {
  constexpr double tolerance = 0.01;
  const double mean_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  return std::abs((time_s[1] - time_s[0]) * rate_Hz - 1.0) < tolerance ||
         std::abs(mean_s * rate_Hz - 1.0) < tolerance;
}

/// Returns true if the times of two channels count as equal: they differ by at most a thousandth of `step_s`,
/// the time since the preceding row.
bool is_one_time(double one_s, double other_s, double step_s) {
  constexpr double same = 1e-3;
  return std::abs(other_s - one_s) <= same * step_s;
}

/// Reads the rows of one file into a dataset and converts times and units.
class RowLoader {
 public:
  RowLoader(LabCsvReader& reader, const DatasetColumns& columns, const DatasetLayout& layout,
            std::size_t most_rows)
      : reader_(reader),
        columns_(columns),
        layout_(layout),
        most_rows_(most_rows),
        seconds_(columns.seconds) {
    if (layout.rate_Hz) {
      rate_Hz_ = *layout.rate_Hz;
      origin_of_rate_ = fmt::format("--rate {}", rate_Hz_);
    } else if (reader.rate()) {
      rate_Hz_ = reader.rate()->rate_Hz;
      origin_of_rate_ = fmt::format("\"{}\" (--rate overrides it)", shortened(reader.rate()->line));
      if (!columns.time_unit_s) seconds_ = 1.0 / rate_Hz_;
    }
    reader_.select(columns.selected, columns.has_time);
    if (reader_.has_clock()) seconds_ = 1.0;
  }

  DatasetFile load() {
    settle_units();
    settle_time();
    read_rows();
    require_agreement();
    std::vector<std::string> notes = reader_.notes();
    loaded_.notes.insert(loaded_.notes.end(), notes.begin(), notes.end());
    return std::move(loaded_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error({reader_.file(), reader_.line_number()}, what);
  }

  std::string without_time() const {
    return fmt::format("--columns {}{} reads the file without its time column",
                       columns_without_time(columns_), layout_.rate_Hz ? "" : " --rate HZ");
  }

  void settle_units() {
    const auto [input_unit, input_scale] =
        unit_of(reader_, "input_unit", columns_.input_unit, columns_.input_scale);
    loaded_.dataset.input_unit = input_unit;
    input_scale_ = input_scale;
    const auto [output_unit, output_scale] =
        unit_of(reader_, "output_unit", columns_.output_unit, columns_.output_scale);
    loaded_.dataset.output_unit = output_unit;
    output_scale_ = output_scale;
    note_units();
    if (!layout_.output_scale || reader_.comment("output_unit").empty()) return;
    const UnitWord* unit = find_unit(output_unit);
    if (unit != nullptr && unit->meaning == ColumnMeaning::output)
      reader_.fail_at_header(
          fmt::format("output_unit is \"{}\" in the file: --output-scale is not allowed", output_unit));
    loaded_.dataset.output_unit = "um";
    output_scale_ *= *layout_.output_scale;
  }

  /// Adds a note for each unknown unit, and a note about the meaning of --output-scale if the unit of the
  /// output is unknown.
  void note_units() {
    const std::size_t first = columns_.has_time ? 1 : 0;
    for (const std::size_t i : {first, first + 1}) {
      const bool is_output = i > first;
      const std::string& unit = reader_.columns()[columns_.selected[i]].unit;
      const std::string& title = columns_.titles[is_output ? 2 : 1];
      const bool is_stated = !reader_.comment(is_output ? "output_unit" : "input_unit").empty();
      if (title.empty() || is_stated || find_unit(unit) != nullptr) continue;
      if (is_output && layout_.output_scale)
        loaded_.notes.push_back(fmt::format("--output-scale {:g} is taken as um per {} of {}",
                                            *layout_.output_scale, unit.empty() ? "1" : unit, title));
      else if (!unit.empty())
        loaded_.notes.push_back(
            fmt::format("the unit {} of {} is unknown, so its numbers are not converted", unit, title));
    }
  }

  /// Determines the duration of one unit of the time column from the first two rows.
  void settle_time() {
    std::vector<double> row, times;
    while (times.size() < 2 && reader_.read(row))
      if (!reader_.is_damaged()) times.push_back(row[0]);
    if (!columns_.has_time) {
      constexpr double same = 1e-6;
      if (times.size() == 2 && !layout_.rate_Hz && std::abs((times[1] - times[0]) * rate_Hz_ - 1.0) < same)
        reader_.fail_at_header(
            fmt::format("the input {} has the times of the rows, expected --columns TIME,INPUT,OUTPUT, or "
                        "--output-from FILE",
                        columns_.titles[1]));
    } else if (times.size() == 2) {
      if (!reader_.has_clock() && rate_Hz_ > 0.0)
        seconds_ = seconds_beside_rate(times[1] - times[0]);
      else if (!reader_.has_clock() && !columns_.time_unit_s)
        settle_unstated(times[0], times[1] - times[0]);
    }
    reader_.rewind();
  }

  void settle_unstated(double first, double step) {
    for (const Epoch& epoch : epochs)
      if (first >= epoch.first && first < epoch.last && step > 0.0 && step <= epoch.longest_step) {
        seconds_ = epoch.unit_s;
        origin_ = first;
        loaded_.notes.push_back(fmt::format("{} is taken as {} since 1970; time starts at the first row",
                                            columns_.titles[0], epoch.name));
        return;
      }
    const bool is_since_1970 = first >= 1.2e9 && first < 2.1e9;
    if (step > 1.0 && step == std::round(step) && !is_since_1970)
      fail(fmt::format(
          "{} increases by {:g} and has no unit, expected a unit in the name of the column (as in t_ms), or "
          "--rate with the rows per second",
          columns_.titles[0], step));
    loaded_.notes.push_back(fmt::format("{} has no unit: it is taken as a time in s", columns_.titles[0]));
  }

  /// Returns the duration of one unit of the time column, in s, for a file with a sampling rate. `step` is
  /// the difference of the first two times. If the column has a unit, `step` must agree with the rate. If it
  /// has no unit, the function tries s, ms, us and ns for a `step` above 1. Any other whole `step` belongs to
  /// sample numbers, and a fraction is in s. Throws Error if `step` does not agree with the rate.
  double seconds_beside_rate(double step) {
    const double unit_s = columns_.time_unit_s.value_or(1.0);
    constexpr double same = 1e-6;
    if (!columns_.time_unit_s && step > 1.0)
      for (const auto& [other_s, name] : {std::pair{1.0, "s"}, {1e-3, "ms"}, {1e-6, "us"}, {1e-9, "ns"}})
        if (std::abs(other_s * step * rate_Hz_ - 1.0) < same) {
          loaded_.notes.push_back(fmt::format("the unit of {} is taken as {}, which agrees with {}",
                                              columns_.titles[0], name, origin_of_rate_));
          return other_s;
        }
    if (!columns_.time_unit_s && step == std::round(step) && step > 0.0) return 1.0 / rate_Hz_;
    // Tolerance for rounded times, such as 0.0003 s at 3 kHz. agrees_with_rate() checks all rows later.
    constexpr double rounded = 0.2;
    if (std::abs(unit_s * step * rate_Hz_ - 1.0) < rounded) return unit_s;
    fail(fmt::format("{} increases by {} s, expected {} s at {}, or whole numbers that count the samples; {}",
                     columns_.titles[0], unit_s * step, 1.0 / rate_Hz_, origin_of_rate_, without_time()));
  }

  void read_rows() {
    std::vector<double> row;
    const identification::Dataset& dataset = loaded_.dataset;
    bool has_begun = false;
    for (std::size_t n = 0; reader_.read(row); ++n) {
      const double t = columns_.has_time ? row[0] : static_cast<double>(n);
      const double time_s = seconds_ * (t - origin_);
      if (!has_begun && layout_.from_s && !(time_s >= *layout_.from_s)) continue;
      if (layout_.to_s && time_s > *layout_.to_s) return;
      has_begun = true;
      if (reader_.is_damaged()) fail_at_damage();
      require_increase(time_s);
      if (dataset.size() == most_rows_)
        throw Error({reader_.file(), reader_.line_number(), 1}, "too many rows",
                    expect("at most {} rows", most_rows_));
      add(time_s, row);
      if (layout_.to_s && time_s >= *layout_.to_s) return;
    }
  }

  void require_increase(double time_s) const {
    const std::vector<double>& times_s = loaded_.dataset.time_s;
    if (times_s.empty() || time_s > times_s.back()) return;
    std::string advice;
    if (time_s == times_s.back())
      advice = fmt::format(": if the time is rounded, {}", without_time());
    else if (layout_.has_interval_options)
      advice = fmt::format(": --to {} selects only the rows before the time goes back", times_s.back());
    fail(fmt::format("{} is {} after {}, expected an increasing time{}", columns_.titles[0],
                     time_s / seconds_ + origin_, times_s.back() / seconds_ + origin_, advice));
  }

  void add(double time_s, const std::vector<double>& row) {
    const std::size_t first = columns_.has_time ? 1 : 0;
    identification::Dataset& dataset = loaded_.dataset;
    dataset.time_s.push_back(time_s);
    dataset.input.push_back(input_scale_ * row[first]);
    dataset.output.push_back(output_scale_ * row[first + 1]);
    for (const double value : {time_s, dataset.input.back(), dataset.output.back()})
      if (!(std::abs(value) <= identification::largest_value))
        fail(fmt::format("a time, input or output is {}, expected at most {} in magnitude{}", value,
                         identification::largest_value,
                         value == time_s ? fmt::format(": {}", without_time()) : ""));
    if (!columns_.has_output_time) return;
    const double step_s = dataset.size() > 1 ? time_s - dataset.time_s[dataset.size() - 2] : 0.0;
    const double output_time_s = seconds_ * (row.back() - origin_);
    if (dataset.size() > 1 && !is_one_time(time_s, output_time_s, step_s))
      fail(fmt::format(
          "the time of the input is {} s and the time of the output is {} s, expected equal times", time_s,
          output_time_s));
  }

  [[noreturn]] void fail_at_damage() {
    const Error damage = reader_.damage_error();
    std::string remedy;
    if (layout_.has_interval_options && !loaded_.dataset.time_s.empty())
      remedy = fmt::format("--to {} selects only the rows before the damage", loaded_.dataset.time_s.back());
    std::vector<double> row;
    while (remedy.empty() && layout_.has_interval_options && columns_.has_time && reader_.read(row))
      if (!reader_.is_damaged())
        remedy =
            fmt::format("--from {} selects only the rows after the damage", seconds_ * (row[0] - origin_));
    throw Error({}, damage, {.remedy = remedy});
  }

  void require_agreement() const {
    const std::vector<double>& time_s = loaded_.dataset.time_s;
    const bool counts_samples = seconds_ == 1.0 / rate_Hz_;
    if (rate_Hz_ > 0.0 && !counts_samples && columns_.has_time && time_s.size() > 1 &&
        !agrees_with_rate(time_s, rate_Hz_))
      throw Error(reader_.file(), fmt::format("{} contradicts the rate", columns_.titles[0]),
                  expect("{} s from row to row at {}", 1.0 / rate_Hz_, origin_of_rate_));
  }

  LabCsvReader& reader_;
  const DatasetColumns& columns_;
  const DatasetLayout& layout_;
  std::size_t most_rows_;
  double seconds_;
  double origin_ = 0.0;   ///< first value of the time column if the column counts from 1970; else 0
  double rate_Hz_ = 0.0;  ///< sampling rate from the user or the file; 0: unknown
  std::string origin_of_rate_;
  double input_scale_ = 1.0, output_scale_ = 1.0;
  DatasetFile loaded_;
};

DatasetFile load_channel(const std::filesystem::path& file, const DatasetLayout& layout,
                         std::size_t most_rows, ColumnMeaning channel) {
  LabCsvReader reader(file, most_rows);
  const DatasetColumns columns = channel_columns(reader, layout, channel);
  return RowLoader(reader, columns, layout, most_rows).load();
}

/// Loads a measurement that is stored in two files: `file` has the input, layout.output_from has the output.
DatasetFile load_two_files(const std::filesystem::path& file, const DatasetLayout& layout,
                           std::size_t most_rows) {
  DatasetFile loaded = load_channel(file, layout, most_rows, ColumnMeaning::input);
  DatasetFile other = load_channel(layout.output_from, layout, most_rows, ColumnMeaning::output);
  identification::Dataset& dataset = loaded.dataset;
  const std::filesystem::path& place = layout.output_from;
  if (other.dataset.size() != dataset.size())
    throw Error(place, counted(other.dataset.size(), "row"),
                expect("{} as in {}", dataset.size(), file.string()));
  for (std::size_t i = 1; i < dataset.size(); ++i) {
    const double step_s = dataset.time_s[i] - dataset.time_s[i - 1];
    if (!is_one_time(dataset.time_s[i], other.dataset.time_s[i], step_s))
      throw Error(place, fmt::format("the time of row {} is {} s", i + 1, other.dataset.time_s[i]),
                  expect("{} s as in {}", dataset.time_s[i], file.string()));
  }
  dataset.output = std::move(other.dataset.output);
  dataset.output_unit = std::move(other.dataset.output_unit);
  for (const std::string& note_text : other.notes)
    loaded.notes.push_back(fmt::format("{}: {}", place.string(), note_text));
  return loaded;
}

}  // namespace

DatasetFile load_dataset(const std::filesystem::path& file, const DatasetLayout& stated,
                         std::size_t most_rows) {
  if (!stated.output_from.empty()) return load_two_files(file, stated, most_rows);
  LabCsvReader reader(file, most_rows);
  DatasetLayout layout = stated;
  if (!layout.rate_Hz && reader.rate()) layout.rate_Hz = reader.rate()->rate_Hz;
  const DatasetColumns columns = dataset_columns(reader, layout);
  DatasetFile loaded = RowLoader(reader, columns, stated, most_rows).load();
  loaded.taken = taken_by_likeness(reader, columns);
  if (!stated.rate_Hz && reader.rate() && !columns.time_unit_s)
    loaded.taken += fmt::format("{}{:g} Hz from \"{}\"", loaded.taken.empty() ? "" : ", ",
                                reader.rate()->rate_Hz, shortened(reader.rate()->line));
  return loaded;
}

}  // namespace hystcan::config
