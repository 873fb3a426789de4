#include "config/files/lab_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

namespace hystcan::config {
namespace {

constexpr std::size_t most_header_lines = 1000;
constexpr std::array<std::string_view, 18> known_units{"s", "ms", "us", "ns", "min", "h",  "V", "mV", "kV",
                                                       "A", "mA", "Hz", "nm", "um",  "mm", "m", "%",  "T"};

std::string without_quotes(std::string_view text) {
  if (text.size() >= 2 && (text.front() == '"' || text.front() == '\'') && text.back() == text.front())
    text = text.substr(1, text.size() - 2);
  return std::string(trimmed(text));
}

/// Both letters that are written for a millionth, in UTF-8 or Latin 1, as u.
std::string with_u(std::string text) {
  for (const std::string_view micro : {"\xC2\xB5", "\xCE\xBC", "\xB5"})
    for (std::size_t at = text.find(micro); at != std::string::npos; at = text.find(micro))
      text.replace(at, micro.size(), "u");
  return text;
}

bool is_known(std::string_view unit) { return std::ranges::find(known_units, unit) != known_units.end(); }

/// Of a line of units: "V", "(V)", or nothing.
std::optional<std::string> only_unit(std::string_view field) {
  if (field.empty()) return std::string();
  const CsvColumn column = csv_column(field);
  if (column.name.empty()) return column.unit;
  std::string text = with_u(column.title);
  if (!is_known(text)) return std::nullopt;
  return text;
}

constexpr std::array<std::string_view, 8> rate_words{"abtastrate",    "abtastfrequenz",     "sampling rate",
                                                     "sample rate",   "sampling frequency", "samplerate",
                                                     "sampling_rate", "sample_rate"};
constexpr std::array<std::pair<std::string_view, double>, 8> rate_units{{{"", 1.0},
                                                                         {"hz", 1.0},
                                                                         {"1/s", 1.0},
                                                                         {"s/s", 1.0},
                                                                         {"sa/s", 1.0},
                                                                         {"samples/s", 1.0},
                                                                         {"khz", 1e3},
                                                                         {"ks/s", 1e3}}};

/// Without blanks, separators and brackets at both ends.
std::string_view without_marks(std::string_view text) {
  constexpr std::string_view marks = "# \t:=;,\"()[]";
  const auto begin = text.find_first_not_of(marks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(marks) - begin + 1);
}

}  // namespace

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  return lower;
}

CsvColumn csv_column(std::string_view title) {
  CsvColumn column{.title = without_quotes(title), .name = {}, .unit = {}};
  const std::string text = with_u(column.title);
  column.name = text;
  for (const auto& [open, close] : {std::pair{'(', ')'}, std::pair{'[', ']'}, std::pair{'<', '>'}})
    if (const auto at = text.find_last_of(open); at != std::string::npos && text.back() == close) {
      column.name = trimmed(std::string_view(text).substr(0, at));
      column.unit = trimmed(std::string_view(text).substr(at + 1, text.size() - at - 2));
      return column;
    }
  for (const std::string_view mark : {" in ", "/", "_"})
    if (const auto at = text.rfind(mark); at != std::string::npos && at > 0)
      if (const std::string unit(trimmed(std::string_view(text).substr(at + mark.size()))); is_known(unit)) {
        column.name = trimmed(std::string_view(text).substr(0, at));
        column.unit = unit;
        return column;
      }
  return column;
}

std::optional<StatedRate> stated_rate(std::string_view line) {
  const std::string lower = lower_case(without_marks(line));
  const auto word =
      std::ranges::find_if(rate_words, [&](std::string_view of) { return lower.starts_with(of); });
  if (word == rate_words.end()) return std::nullopt;
  const std::string_view rest = std::string_view(lower).substr(word->size());
  const std::size_t begin = std::min(rest.find_first_of("0123456789"), rest.size());
  const std::size_t end = std::min(rest.find_first_not_of("0123456789.,e", begin), rest.size());
  const std::string_view number = without_marks(rest.substr(begin, end - begin));
  std::string unit(without_marks(rest.substr(0, begin)));  // Abtastrate [Hz]: 5000
  unit += without_marks(rest.substr(end));
  const auto known = std::ranges::find(rate_units, unit, &std::pair<std::string_view, double>::first);
  const auto value = csv_number(number, true);
  if (!value || known == rate_units.end()) return std::nullopt;
  const std::size_t point = number.find_first_of(".,");
  if (point != std::string_view::npos && number.size() - point == 4)
    return std::nullopt;  // five, or thousands
  const double rate_Hz = *value * known->second;
  if (!(rate_Hz > 0.0)) return std::nullopt;
  return StatedRate{rate_Hz, std::string(trimmed(line))};
}

LabCsvReader::LabCsvReader(std::filesystem::path file) : lines_(std::move(file)) { find_header(); }

LabCsvReader::Likeness LabCsvReader::row_likeness(std::string_view line, char separator) {
  split_fields(line, separator, fields_);
  std::size_t numbers = 0, texts = 0;
  for (const std::string_view field : fields_) {
    if (csv_number(field, separator != ','))
      ++numbers;
    else if (!field.empty())
      ++texts;
  }
  return numbers < 2 || numbers < texts ? Likeness::none : texts > 0 ? Likeness::some : Likeness::full;
}

// A line of numbers is the first row if the line before has as many fields, or if the next line is one, too.
void LabCsvReader::find_header() {
  std::vector<CsvLines::Kept> before, rows;
  std::size_t fields = 0;
  const auto fields_of = [&](const CsvLines::Kept& line) {
    split_fields(line.text, separator_, fields_);
    return fields_.size();
  };
  while (lines_.next()) {
    CsvLines::Kept line = lines_.kept();
    if (before.size() > most_header_lines)
      lines_.fail(fmt::format("no rows of numbers in the first {} lines, expected a header and rows below it",
                              most_header_lines));
    if (!rows.empty()) {
      if (before.empty() ||
          (row_likeness(line.text, separator_) != Likeness::none && fields_.size() == fields)) {
        rows.push_back(std::move(line));
        break;
      }
      before.push_back(std::move(rows.front()));
      rows.clear();
    }
    Likeness alike = Likeness::none;
    for (const char separator : {';', '\t', ',', ' '}) {
      alike = row_likeness(line.text, separator);
      separator_ = separator;
      if (alike != Likeness::none) break;
    }
    fields = fields_.size();
    if (alike == Likeness::none) {
      before.push_back(std::move(line));
      continue;
    }
    rows.push_back(std::move(line));
    if (alike == Likeness::full && !before.empty() && fields_of(before.back()) == fields) break;
  }
  lines_.end_comments();
  if (before.empty() && rows.empty()) lines_.fail("no header row, expected column names");
  if (rows.empty()) {  // rows that cannot be read, or none
    for (const char separator : {' ', ',', '\t', ';'})
      if (before.front().text.find(separator) != std::string::npos) separator_ = separator;
    rows.assign(std::make_move_iterator(before.begin() + 1), std::make_move_iterator(before.end()));
    before.resize(1);
    fields = fields_of(before.front());
  } else {
    fields = fields_of(rows.front());
  }
  if (fields > most_columns)
    lines_.fail(fmt::format("{} columns, expected at most {}", fields, most_columns));
  std::vector<StatedRate> rates;
  for (const std::string& comment : lines_.comments())
    if (auto rate = stated_rate(comment)) rates.push_back(std::move(*rate));
  for (const CsvLines::Kept& line : before)
    if (auto rate = stated_rate(line.text)) rates.push_back(std::move(*rate));
  if (!rates.empty() &&
      std::ranges::all_of(rates, [&](const StatedRate& one) { return one.rate_Hz == rates.front().rate_Hz; }))
    rate_ = rates.front();
  read_names(before, fields);
  for (CsvLines::Kept& row : rows) lines_.put_back(std::move(row));
}

void LabCsvReader::read_names(const std::vector<CsvLines::Kept>& before, std::size_t fields) {
  const auto fits = [&](std::size_t i) {
    split_fields(before[i].text, separator_, fields_);
    return fields_.size() == fields || fields_.size() + 1 == fields;
  };
  std::optional<std::size_t> header;
  if (!before.empty() && (fits(before.size() - 1) || before.size() == 1)) header = before.size() - 1;
  std::vector<std::string> units;
  if (header && *header > 0 && fits(*header - 1)) {
    split_fields(before[*header].text, separator_, fields_);
    for (const std::string_view field : fields_)
      if (const std::optional<std::string> unit = only_unit(field)) units.push_back(*unit);
    if (units.size() == fields_.size())
      --*header;
    else
      units.clear();
  }
  if (header) {
    split_fields(before[*header].text, separator_, fields_);
    header_line_ = before[*header].number;
    has_header_ = true;
    for (const std::string_view field : fields_) columns_.push_back(csv_column(field));
  }
  for (std::size_t i = columns_.size(); i < fields && !has_header_; ++i)
    columns_.push_back({std::to_string(i + 1), std::to_string(i + 1), ""});
  for (std::size_t i = 0; i < std::min(units.size(), columns_.size()); ++i) columns_[i].unit = units[i];
  std::set<std::string_view> names;
  for (const CsvColumn& column : columns_)
    if (!column.title.empty() && !names.insert(column.title).second)
      fail_at_header(fmt::format("column {} occurs twice, expected each name once", shortened(column.title)));
}

void LabCsvReader::fail_at_header(const std::string& what) const {
  throw Error(fmt::format("{}:{}:1: {}", lines_.file().string(), header_line_, what));
}

bool LabCsvReader::next(std::vector<double>& row) {
  if (!lines_.next()) return false;
  split_fields(lines_.text(), separator_, fields_);
  if (fields_.size() == columns_.size() + 1 && fields_.back().empty()) fields_.pop_back();
  require_width(lines_, fields_.size(), columns_.size(), separator_);
  row.resize(selected_.size());
  for (std::size_t i = 0; i < selected_.size(); ++i)
    row[i] = finite_number(lines_, fields_[selected_[i]], columns_[selected_[i]].title, separator_);
  return true;
}

}  // namespace hystcan::config
