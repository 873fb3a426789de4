#include "config/files/dataset_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/files/lab_csv.h"

namespace hystcan::config {
namespace {

constexpr std::array<std::string_view, 3> column_meanings{"time", "input", "output"};

struct DatasetColumns {
  std::vector<std::size_t>
      selected;  ///< time, input, output; without time if rate_Hz is given and no column is one
  std::array<std::string, 3> titles;    ///< time, input, output
  double seconds = 1.0;                 ///< of one unit of time, or of one sample where a rate is stated
  std::optional<double> time_unit_s{};  ///< where the column states a unit
  double input_scale = 1.0, output_scale = 1.0;
  std::string input_unit, output_unit;  ///< empty: unknown
  bool by_likeness = false;             ///< else the names are time_s, input, output, or the user's

  bool has_time() const { return selected.size() == 3; }
};

using Words = std::span<const std::string_view>;

constexpr std::array<std::string_view, 3> usual_names{"time_s", "input", "output"};

// Whole names, in lower case, the likeliest first.
constexpr std::array<std::string_view, 11> time_words{"time",  "t", "zeit", "timestamp", "elapsed",  "sample",
                                                      "index", "n", "#",    "nr",        "messpunkt"};
constexpr std::array<std::string_view, 19> input_words{
    "input",       "drive",         "voltage",        "u",        "v",       "volt",  "current",
    "i",           "command",       "setpoint",       "h",        "field",   "strom", "excitation",
    "ansteuerung", "piezospannung", "steuerspannung", "sollwert", "spannung"};
constexpr std::array<std::string_view, 18> output_words{
    "output",         "position", "pos",        "x", "y",          "displacement", "disp",    "stroke",
    "sensor",         "strain",   "elongation", "b", "deflection", "measured",     "istwert", "wegsensor",
    "sensorspannung", "weg"};
constexpr Words sample_words = Words(time_words).subspan(5);
constexpr std::array<Words, 3> usual_words{time_words, input_words, output_words};

constexpr std::array<std::string_view, 6> time_units{"s", "ms", "us", "ns", "min", "h"};
constexpr std::array<std::string_view, 5> input_units{"V", "mV", "kV", "A", "mA"};
constexpr std::array<std::string_view, 4> output_units{"nm", "um", "mm", "m"};
constexpr std::array<Words, 3> usual_units{time_units, input_units, output_units};

struct Scale {
  std::string_view unit, base;
  double factor;
};
constexpr std::array<Scale, 9> scales{{{"ms", "s", 1e-3},
                                       {"us", "s", 1e-6},
                                       {"ns", "s", 1e-9},
                                       {"min", "s", 60.0},
                                       {"h", "s", 3600.0},
                                       {"mV", "V", 1e-3},
                                       {"kV", "V", 1e3},
                                       {"mA", "A", 1e-3},
                                       {"s", "s", 1.0}}};

bool has(Words list, std::string_view word) { return std::ranges::find(list, word) != list.end(); }

/// How likely a column has this meaning; 0: it has not.
int likeness(const CsvColumn& column, std::size_t meaning) {
  const std::string name = lower_case(column.name);
  int points = 0;
  if (has(usual_words[meaning], name)) points = 4;
  for (const std::string_view word : usual_words[meaning])
    if (points == 0 && word.size() > 2 && name.find(word) != std::string::npos) points = 2;
  if (has(usual_units[meaning], column.unit)) points += 3;
  for (std::size_t other = 0; other < usual_units.size(); ++other)
    if (other != meaning && has(usual_units[other], column.unit)) points -= 2;
  return std::max(points, 0);
}

/// With the unit, where it is not a part of the title.
std::string title_with_unit(const CsvColumn& column) {
  const bool is_part = column.title.find(column.unit) != std::string::npos;
  return is_part ? column.title : fmt::format("{} [{}]", column.title, column.unit);
}

std::vector<std::string> titles_of(const std::vector<CsvColumn>& columns) {
  std::vector<std::string> titles(columns.size());
  std::ranges::transform(columns, titles.begin(), title_with_unit);
  return titles;
}

class Choice {
 public:
  Choice(const LabCsvReader& reader, const DatasetLayout& layout) : reader_(reader), layout_(layout) {}

  DatasetColumns made() {
    if (!layout_.columns.empty())
      by_user();
    else if (!by_usual_names())
      by_likeness();
    require_known_time();
    settle_units();
    return std::move(choice_);
  }

 private:
  const std::vector<CsvColumn>& columns() const { return reader_.columns(); }
  std::string listed_columns() const { return listed(titles_of(columns())); }

  void take(std::size_t meaning, std::size_t column) {
    choice_.selected.push_back(column);
    choice_.titles[meaning] = columns()[column].title;
    units_[meaning] = columns()[column].unit;
  }

  bool by_usual_names() {
    std::vector<std::size_t> found;
    for (const std::string_view name : usual_names) {
      const auto at = std::ranges::find(columns(), name, &CsvColumn::title);
      if (at == columns().end()) return false;
      found.push_back(static_cast<std::size_t>(at - columns().begin()));
    }
    for (std::size_t meaning = 0; meaning < found.size(); ++meaning) take(meaning, found[meaning]);
    return true;
  }

  void by_user() {
    std::vector<std::string> named;
    for (std::size_t begin = 0; begin <= layout_.columns.size();) {
      const std::size_t end = std::min(layout_.columns.find(',', begin), layout_.columns.size());
      named.emplace_back(trimmed(std::string_view(layout_.columns).substr(begin, end - begin)));
      begin = end + 1;
    }
    const std::size_t first = named.size() == 2 && layout_.rate_Hz ? 1 : 0;  // without time
    if (named.size() + first != 3)
      throw Error(fmt::format("--columns is {}, expected three names, of time, input and output{}",
                              layout_.columns, first == 0 ? "; with --rate the time may be left out" : ""));
    for (std::size_t i = 0; i < named.size(); ++i) take(i + first, named_column(named[i]));
    if (takes_a_column_twice())
      throw Error(fmt::format("--columns is {}: one column for two meanings, expected as many columns",
                              layout_.columns));
  }

  std::size_t named_column(const std::string& name) const {
    for (const std::string CsvColumn::*part : {&CsvColumn::title, &CsvColumn::name})
      if (const auto at = std::ranges::find(columns(), name, part); at != columns().end())
        return static_cast<std::size_t>(at - columns().begin());
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (error == std::errc() && end == name.data() + name.size() && number >= 1 && number <= columns().size())
      return number - 1;
    reader_.fail_at_header(fmt::format("no column {}, expected one of {}, or a number from 1 to {}", name,
                                       listed_columns(), columns().size()));
  }

  void by_likeness() {
    if (!reader_.has_header())
      reader_.fail_at_header(
          fmt::format("no header row, expected column names, or --columns with the numbers of time, "
                      "input and output, 1 to {}",
                      columns().size()));
    choice_.by_likeness = true;
    for (std::size_t meaning = 0; meaning < column_meanings.size(); ++meaning) {
      const auto [column, is_alone] = likeliest(meaning);
      if (!column && meaning == 0 && layout_.rate_Hz) continue;
      if (!column || !is_alone)
        reader_.fail_at_header(
            fmt::format("{} column is the {} among {}, expected time_s, input, output, or --columns "
                        "TIME,INPUT,OUTPUT",
                        column ? "more than one" : "no", column_meanings[meaning], listed_columns()));
      take(meaning, *column);
    }
    if (takes_a_column_twice())
      reader_.fail_at_header(fmt::format(
          "one column for two meanings among {}, expected --columns TIME,INPUT,OUTPUT", listed_columns()));
  }

  bool takes_a_column_twice() const {
    std::vector<std::size_t> sorted = choice_.selected;
    std::ranges::sort(sorted);
    return std::ranges::adjacent_find(sorted) != sorted.end();
  }

  /// Its index, and whether no other column is as likely.
  std::pair<std::optional<std::size_t>, bool> likeliest(std::size_t meaning) const {
    std::optional<std::size_t> column;
    bool is_alone = true;
    int most = 0;
    for (std::size_t i = 0; i < columns().size(); ++i) {
      const int points = likeness(columns()[i], meaning);
      if (points == 0 || points < most) continue;
      is_alone = points > most;
      column = i;
      most = points;
    }
    return {column, is_alone};
  }

  /// A wrong guess would be wrong by a thousand, and every figure of a result would look right.
  void require_known_time() const {
    if (!choice_.has_time()) return;
    const CsvColumn& time = columns()[choice_.selected[0]];
    const bool has_words = time.unit.empty() && time.name.find(" in ") != std::string::npos;
    if (has_words || (!time.unit.empty() && !has(time_units, time.unit)))
      reader_.fail_at_header(fmt::format("the unit of {} is not known, expected one of {}",
                                         shortened(time.title), fmt::join(time_units, ", ")));
    if (choice_.by_likeness && !layout_.rate_Hz && time.unit.empty() &&
        has(sample_words, lower_case(time.name)))
      reader_.fail_at_header(fmt::format(
          "{} is the number of the sample, expected --rate, the samples per second", shortened(time.title)));
  }

  void settle_units() {
    const auto scale = [](const std::string& unit) {
      const auto at = std::ranges::find(scales, unit, &Scale::unit);
      return at == scales.end() ? Scale{unit, unit, 1.0} : *at;
    };
    choice_.seconds = scale(units_[0]).factor;
    if (!units_[0].empty()) choice_.time_unit_s = choice_.seconds;
    choice_.input_unit = scale(units_[1]).base;
    choice_.input_scale = scale(units_[1]).factor;
    choice_.output_unit = units_[2];
    if (layout_.output_scale && has(output_units, units_[2]))
      reader_.fail_at_header(fmt::format("{} is a length in {}, expected no --output-scale",
                                         shortened(choice_.titles[2]), units_[2]));
    if (layout_.output_scale) {
      choice_.output_scale = *layout_.output_scale;
      choice_.output_unit = "um";
    }
    if (layout_.rate_Hz) choice_.seconds = 1.0 / *layout_.rate_Hz;
  }

  const LabCsvReader& reader_;
  const DatasetLayout& layout_;
  DatasetColumns choice_;
  std::array<std::string, 3> units_;
};

/// Throws Error at the header if a column is missing or if two are alike.
DatasetColumns dataset_columns(const LabCsvReader& reader, const DatasetLayout& layout) {
  return Choice(reader, layout).made();
}

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
