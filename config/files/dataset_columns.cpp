#include "config/files/dataset_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "config/files/csv.h"

namespace hystcan::config {
namespace {

constexpr std::array<std::string_view, 3> usual_names{"time_s", "input", "output"};

/// Returns a score of how likely the column has this meaning, from its name and its unit. 0: the column has
/// another meaning.
int likeness(const CsvColumn& column, ColumnMeaning meaning) {
  int points = name_likeness(lower_case(column.name), meaning);
  const UnitWord* unit = find_unit(column.unit);
  if (unit != nullptr && unit->meaning) points += unit->meaning == meaning ? 3 : -2;
  return std::max(points, 0);
}

/// Returns the title followed by the unit, "drive [V]". Returns only the title if it contains the unit.
std::string title_with_unit(const CsvColumn& column) {
  const bool is_part = column.title.find(column.unit) != std::string::npos;
  return is_part ? column.title : fmt::format("{} [{}]", column.title, column.unit);
}

std::vector<std::string> titles_of(const std::vector<CsvColumn>& columns) {
  std::vector<std::string> titles;
  for (const CsvColumn& column : columns)
    if (!column.title.empty()) titles.push_back(title_with_unit(column));
  return titles;
}

class ColumnSelector {
 public:
  ColumnSelector(const LabCsvReader& reader, const DatasetLayout& layout)
      : reader_(reader), layout_(layout) {}

  DatasetColumns of_channel(ColumnMeaning channel) {
    std::vector<std::string> named = named_columns();
    const std::size_t width = layout_.rate_Hz ? 1 : 2;
    if (channel == ColumnMeaning::output && named.size() == 2 * width)
      named.erase(named.begin(), named.begin() + static_cast<std::ptrdiff_t>(width));
    if (named.size() == 2 * width) named.resize(width);
    std::vector<std::size_t> found = reader_.value_columns();
    if (!layout_.columns.empty() && named.size() != width)
      throw Error("--columns is " + layout_.columns,
                  expect("{}, once for both files, or first for the input file and then for the output file",
                         width == 1 ? "the name of the value column"
                                    : "the names of the time column and the value column"));
    if (!layout_.columns.empty()) {
      found.clear();
      for (const std::string& name : named) found.push_back(named_column(name));
    }
    if (found.size() != width)
      reader_.fail_at_header(
          fmt::format("{} of numbers, expected one channel: select the channel with --columns {}",
                      counted(found.size(), "column"), width == 1 ? "VALUE" : "TIME,VALUE, or --rate"));
    if (width == 2) take(0, found.front());
    take(static_cast<std::size_t>(channel), found.back());
    choice_.selected.push_back(found.back());
    require_known_time();
    require_no_time();
    if (channel == ColumnMeaning::input) require_drive();
    settle_units();
    return std::move(choice_);
  }

  DatasetColumns made() {
    if (!layout_.columns.empty())
      by_user();
    else if (!by_usual_names())
      by_likeness();
    require_known_time();
    require_no_time();
    require_drive();
    settle_units();
    return std::move(choice_);
  }

 private:
  const std::vector<CsvColumn>& columns() const { return reader_.columns(); }
  std::string listed_columns() const { return listed(titles_of(columns())); }

  void take(std::size_t meaning, std::size_t column) {
    choice_.selected.push_back(column);
    choice_.has_time = choice_.has_time || meaning == 0;
    choice_.titles[meaning] = columns()[column].title;
    units_[meaning] = columns()[column].unit;
  }

  void take_output_time(std::size_t column) {
    choice_.selected.push_back(column);
    choice_.has_output_time = true;
    if (columns()[column].unit != units_[0])
      reader_.fail_at_header(fmt::format("the units of the times {} and {} differ, expected the same unit",
                                         title_with_unit(columns()[choice_.selected[0]]),
                                         title_with_unit(columns()[column])));
  }

  bool by_usual_names() {
    std::vector<std::size_t> found;
    for (const std::string_view name : usual_names) {
      const auto at = std::ranges::find(columns(), name, &CsvColumn::title);
      if (at == columns().end()) return false;
      require_once(at->title);
      found.push_back(static_cast<std::size_t>(at - columns().begin()));
    }
    for (std::size_t meaning = 0; meaning < found.size(); ++meaning) take(meaning, found[meaning]);
    return true;
  }

  void require_once(const std::string& title) const {
    if (std::ranges::count(columns(), title, &CsvColumn::title) > 1)
      reader_.fail_at_header(fmt::format(
          "column {} occurs twice, expected each name once, or --columns with numbers from 1 to {}",
          shortened(title), columns().size()));
  }

  // Selects the user's columns: TIME,INPUT,OUTPUT or TIME,INPUT,TIME,OUTPUT; with --rate: INPUT,OUTPUT.
  void by_user() {
    std::vector<std::string> named = named_columns();
    const std::size_t first = named.size() == 2 && layout_.rate_Hz ? 1 : 0;  // 1: no time column is named
    if (named.size() + first != 3 && named.size() != 4)
      throw Error("--columns is " + layout_.columns,
                  expect("three names: time, input and output{}",
                         first == 0 ? "; the name of the time is optional with --rate" : ""));
    std::optional<std::size_t> output_time;
    if (named.size() == 4) {
      output_time = named_column(named[2]);
      named.erase(named.begin() + 2);
    }
    for (std::size_t i = 0; i < named.size(); ++i) take(i + first, named_column(named[i]));
    if (takes_a_column_twice())
      throw Error("--columns is " + layout_.columns, "the same column is named twice",
                  expect("different columns"));
    if (output_time && *output_time != choice_.selected[0]) take_output_time(*output_time);
  }

  std::vector<std::string> named_columns() const {
    std::vector<std::string> named;
    for (std::size_t begin = 0; begin <= layout_.columns.size();) {
      const std::size_t end = std::min(layout_.columns.find(',', begin), layout_.columns.size());
      named.emplace_back(trimmed(std::string_view(layout_.columns).substr(begin, end - begin)));
      begin = end + 1;
    }
    return named;
  }

  /// Returns the index of the column with this name, or with this number from 1. A number is always the
  /// position of a column, even if another column has this number as its name.
  std::size_t named_column(const std::string& name) const {
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (error == std::errc() && end == name.data() + name.size() && number >= 1 && number <= columns().size())
      return number - 1;
    for (const std::string CsvColumn::*part : {&CsvColumn::title, &CsvColumn::name})
      if (const auto at = std::ranges::find(columns(), name, part); at != columns().end()) {
        require_once(at->title);
        return static_cast<std::size_t>(at - columns().begin());
      }
    reader_.fail_at_header(fmt::format("no column {}, expected one of {}, or a number from 1 to {}", name,
                                       listed_columns(), columns().size()));
  }

  void by_likeness() {
    const bool has_rate = layout_.rate_Hz && (reader_.has_header() || !reader_.rate());
    if (reader_.value_columns().size() == 2 && !has_rate)
      reader_.fail_at_header(
          "two columns of numbers, expected time, input and output: --output-from FILE reads "
          "the output from another file, and --rate HZ reads a file without time");
    if (!reader_.has_header())
      reader_.fail_at_header(
          fmt::format("no header row, expected column names, or --columns with the column numbers of time, "
                      "input and output, 1 to {}",
                      columns().size()));
    choice_.by_likeness = true;
    const auto input = likeliest(ColumnMeaning::input), output = likeliest(ColumnMeaning::output);
    const auto times = times_of(input, output);
    for (std::size_t meaning = 0; meaning < column_meanings.size(); ++meaning) {
      const auto& [column, is_alone] = meaning == 0 ? times.first : meaning == 1 ? input : output;
      if (!column && meaning == 0 && layout_.rate_Hz) continue;
      if (column && !is_alone) require_once(columns()[*column].title);
      if (!column || !is_alone)
        reader_.fail_at_header(fmt::format(
            "{} among {} can be the {}, expected columns named time_s, input and output, or --columns "
            "{}INPUT,OUTPUT with column names or numbers from 1 to {}",
            column ? "more than one column" : "no column", listed_columns(), column_meanings[meaning],
            layout_.rate_Hz && !times.first.first ? "" : "TIME,", columns().size()));
      take(meaning, *column);
    }
    if (takes_a_column_twice())
      reader_.fail_at_header(fmt::format(
          "the same column among {} was selected twice for time, input and output, expected --columns "
          "TIME,INPUT,OUTPUT",
          listed_columns()));
    if (times.second) take_output_time(*times.second);
  }

  bool takes_a_column_twice() const {
    std::vector<std::size_t> sorted = choice_.selected;
    std::ranges::sort(sorted);
    return std::ranges::adjacent_find(sorted) != sorted.end();
  }

  /// The index of the column that is most likely the time, the input or the output; nullopt if no column is
  /// likely. The second member is true if no other column is equally likely.
  using Likeliest = std::pair<std::optional<std::size_t>, bool>;

  Likeliest likeliest(ColumnMeaning meaning) const {
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

  /// Returns the time column of the input and the time column of the output. The second one is nullopt if
  /// input and output share the time. They have separate times if several time columns have the same title,
  /// and different ones of these columns are the nearest to the left of the input and to the left of the
  /// output.
  std::pair<Likeliest, std::optional<std::size_t>> times_of(const Likeliest& input,
                                                            const Likeliest& output) const {
    const Likeliest time = likeliest(ColumnMeaning::time);
    if (!time.first || time.second || !input.first || !output.first) return {time, std::nullopt};
    const std::string& title = columns()[*time.first].title;
    const auto before = [&](std::size_t channel) -> std::optional<std::size_t> {
      for (std::size_t i = channel; i-- > 0;)
        if (columns()[i].title == title) return i;
      return std::nullopt;
    };
    const auto first = before(*input.first), second = before(*output.first);
    if (!first || !second || first == second) return {time, std::nullopt};
    return {{first, true}, second};
  }

  /// Throws Error if the unit of the time is unknown. A guess could be wrong by a factor of a thousand, and
  /// the results would still look plausible.
  void require_known_time() const {
    if (!choice_.has_time) return;
    const CsvColumn& time = columns()[choice_.selected[0]];
    const UnitWord* unit = find_unit(time.unit);
    const bool has_words = time.unit.empty() && time.name.find(" in ") != std::string::npos;
    const bool is_other = unit == nullptr || unit->meaning != ColumnMeaning::time;
    if (has_words || (!time.unit.empty() && is_other))
      reader_.fail_at_header(fmt::format("the unit of {} is not known, expected one of {}",
                                         shortened(time.title), listed_units(ColumnMeaning::time)));
    if (choice_.by_likeness && !layout_.rate_Hz && time.unit.empty() && counts_samples(lower_case(time.name)))
      reader_.fail_at_header(
          fmt::format("{} is a sample number, expected a time, or --rate with the samples per second",
                      shortened(time.title)));
  }

  void require_no_time() const {
    for (std::size_t i = 1; i < units_.size(); ++i)
      if (const UnitWord* unit = find_unit(units_[i]);
          unit != nullptr && unit->meaning == ColumnMeaning::time)
        reader_.fail_at_header(
            fmt::format("{} is a time in {}, expected the {}: select the column of the {} with --columns",
                        shortened(choice_.titles[i]), unit->symbol, column_meanings[i], column_meanings[i]));
  }

  void require_drive() const {
    const UnitWord* unit = find_unit(units_[1]);
    if (unit != nullptr && unit->meaning == ColumnMeaning::output)
      reader_.fail_at_header(
          fmt::format("{} is a position in {}, expected the drive of the actuator in V or A as the input: "
                      "select the column of the drive with --columns",
                      shortened(choice_.titles[1]), unit->symbol));
  }

  void settle_units() {
    const auto unit_of = [](const std::string& unit) {
      const UnitWord* known = find_unit(unit);
      return known == nullptr ? UnitWord{unit, unit, 1.0, std::nullopt, ""} : *known;
    };
    choice_.seconds = unit_of(units_[0]).factor;
    if (units_[0].empty()) choice_.seconds = 1.0;
    if (!units_[0].empty()) choice_.time_unit_s = choice_.seconds;
    const UnitWord input = unit_of(units_[1]), output = unit_of(units_[2]);
    choice_.input_unit = input.base;
    choice_.input_scale = input.factor;
    choice_.output_unit = output.base;
    choice_.output_scale = output.factor;
    if (layout_.output_scale && output.meaning == ColumnMeaning::output)
      reader_.fail_at_header(fmt::format("{} is a length in {}: --output-scale is not allowed",
                                         shortened(choice_.titles[2]), output.symbol));
    if (layout_.output_scale) {
      choice_.output_scale *= *layout_.output_scale;
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
  return ColumnSelector(reader, layout).made();
}

DatasetColumns channel_columns(const LabCsvReader& reader, const DatasetLayout& layout,
                               ColumnMeaning channel) {
  return ColumnSelector(reader, layout).of_channel(channel);
}

std::string taken_by_likeness(const LabCsvReader& reader, const DatasetColumns& columns) {
  if (!columns.by_likeness) return {};
  std::string text;
  const std::size_t first = columns.has_time ? 0 : 1;
  for (std::size_t i = 0; i + first < column_meanings.size(); ++i) {
    const CsvColumn& column = reader.columns()[columns.selected[i]];
    text += fmt::format("{}{} from {}{}", i == 0 ? "" : ", ", column_meanings[i + first], column.title,
                        column.unit.empty() ? "" : fmt::format(" in {}", column.unit));
  }
  return text;
}

std::string columns_without_time(const DatasetColumns& columns) {
  const std::size_t first = columns.has_time ? 1 : 0;
  return fmt::format("{},{}", columns.selected[first] + 1, columns.selected[first + 1] + 1);
}

}  // namespace hystcan::config
