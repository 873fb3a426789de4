#include "config/files/dataset_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <span>
#include <string_view>

namespace hystcan::config {
namespace {

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

  struct Likeliest {
    std::optional<std::size_t> column;
    bool is_alone = true;
  };
  Likeliest likeliest(std::size_t meaning) const {
    Likeliest found;
    int most = 0;
    for (std::size_t i = 0; i < columns().size(); ++i) {
      const int points = likeness(columns()[i], meaning);
      if (points == 0 || points < most) continue;
      found.is_alone = points > most;
      found.column = i;
      most = points;
    }
    return found;
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

}  // namespace

DatasetColumns dataset_columns(const LabCsvReader& reader, const DatasetLayout& layout) {
  return Choice(reader, layout).made();
}

}  // namespace hystcan::config
