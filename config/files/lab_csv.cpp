#include "config/files/lab_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "config/files/csv.h"

namespace hystcan::config {
namespace {

/// Maximum number of rows in a summary, such as sums or means, below the record. A block of rows below a
/// blank line is a summary if it has at most this number of rows and the block above has more than ten times
/// as many.
constexpr std::size_t longest_small_block = 9;

bool may_begin_a_decimal(std::string_view digits) {
  return digits.size() > 1 && digits.front() == '0' &&
         digits.find_first_not_of("0123456789") == std::string_view::npos;
}

}  // namespace

LabCsvReader::LabCsvReader(std::filesystem::path file, std::size_t most_rows)
    : text_(std::move(file), most_rows + most_head_lines), shape_(find_row_shape(text_)) {
  first_ = shape_.rows == 0 ? shape_of_names() : before_first_row(text_, shape_);
  read_head_above();
  if (shape_.width() > most_columns)
    text_.fail(first_, {}, fmt::format("{} columns, expected at most {}", shape_.width(), most_columns));
  find_foot();
  find_signs();
  line_ = first_;
}

/// For a record without rows: determines the columns from the first line with content, and returns this line.
TextLine LabCsvReader::shape_of_names() {
  TextLine line;
  if (!text_.next_content(line)) text_.fail(line, {}, "no header row, expected column names");
  for (const char separator : {' ', ',', '\t', ';'})
    if (line.text.find(separator) != std::string_view::npos) shape_.separator = separator;
  split_fields(line.text, shape_.separator, fields_);
  if (fields_.size() > 1 && fields_.back().empty()) fields_.pop_back();
  shape_.numbers.assign(fields_.size(), false);
  return line;
}

void LabCsvReader::read_head_above() {
  std::vector<TextLine> head;
  for (TextLine above; above.number < first_.number && text_.next(above);) head.push_back(above);
  head_ = read_head(head, shape_, settings_beside());
}

/// Returns the rows that have an instrument setting to the left of their numbers. Some instruments write such
/// rows.
/// Only the first 100 rows are examined.
std::vector<TextLine> LabCsvReader::settings_beside() {
  constexpr std::size_t examined_lines = 100;
  std::vector<TextLine> beside;
  TextLine line = first_;
  for (std::size_t n = 0; n < examined_lines && text_.next_content(line); ++n) {
    split_fields(line.text, shape_.separator, fields_);
    if (!shape_.numbers.front() && !fields_.front().empty() && !is_value(fields_.front()))
      beside.push_back(line);
  }
  return beside;
}

void LabCsvReader::find_foot() {
  const std::string_view all = text_.text();
  end_ = all.size();
  if (shape_.rows == 0) return;
  while (end_ > first_.next) {
    const std::size_t before = all.substr(0, end_ - 1).rfind('\n');
    const std::size_t begin = before == std::string_view::npos ? 0 : before + 1;
    if (begin < first_.next) return;
    TextLine line{.next = begin};
    text_.next(line);
    split_fields(line.text, shape_.separator, fields_);
    if (!line.is_blank() && !line.is_comment()) {
      if (has_value_of(fields_, shape_)) return leave_out_small_block();
      has_foot_ = true;
    }
    end_ = begin;
  }
}

/// Ends the rows before a summary, such as sums or means, that some programs write below the rows.
void LabCsvReader::leave_out_small_block() {
  const std::string_view all = text_.text();
  std::size_t below = 0, above = 0, blank = 0;  // rows below and above the blank line, and its position
  for (std::size_t end = end_; end > first_.next && above <= 10 * below;) {
    const std::size_t before = all.substr(0, end - 1).rfind('\n');
    end = before == std::string_view::npos ? 0 : before + 1;
    TextLine line{.next = end};
    if (end < first_.next || !text_.next(line)) return;
    split_fields(line.text, shape_.separator, fields_);
    if (!line.is_comment() && has_value_of(fields_, shape_))
      ++(blank == 0 ? below : above);
    else if (above > 0 || !line.is_blank())
      return;
    else
      blank = end;
    if (below > longest_small_block) return;
  }
  if (above <= 10 * below) return;
  end_ = blank;
  has_foot_ = true;
}

void LabCsvReader::find_signs() {
  const std::string_view rows = text_.text().substr(first_.next, end_ - std::min(end_, first_.next));
  const bool has_point = rows.find('.') != std::string_view::npos;
  const bool has_comma = rows.find(',') != std::string_view::npos;
  if (shape_.separator == ',' && rows.find('"') == std::string_view::npos) {
    if (!has_point) refuse_split_decimals();
    return;
  }
  if (!has_point && !has_comma) return;
  SignSurvey survey;
  const bool is_enough = shape_.separator != ',' && has_point != has_comma;
  for (TextLine line = first_; text_.next_content(line) && line.begin < end_;) {
    split_fields(line.text, shape_.separator, fields_);
    for (std::size_t i = 0; i < fields_.size(); ++i)
      survey.add(fields_[i], line.number,
                 static_cast<std::size_t>(fields_[i].data() - text_.text().data()) - line.begin + 1, i);
    if (is_enough && survey.has_decimal(has_comma ? ',' : '.')) break;
  }
  if (const auto contradiction = survey.contradiction()) throw Error(file(), *contradiction);
  signs_ = survey.found();
}

/// Throws Error if decimal commas seem to split numbers into two fields, because commas also separate the
/// fields. Example: the row 0,0100,2,25 has the two numbers 0.0100 and 2.25.
void LabCsvReader::refuse_split_decimals() const {
  constexpr std::size_t examined_lines = 100;
  std::vector<std::string_view> fields;
  TextLine line = first_;
  for (std::size_t n = 0; n < examined_lines && text_.next_content(line) && line.begin < end_; ++n) {
    split_fields(line.text, ',', fields);
    const bool is_twice = head_.has_names && fields.size() == 2 * head_.columns.size();
    const auto digits = std::ranges::find_if(fields, may_begin_a_decimal);
    if (!is_twice && digits == fields.end()) continue;
    text_.fail(
        line, digits == fields.end() ? fields.front() : *digits,
        "commas are decimal signs and also separators, expected semicolons between the fields or quotes "
        "around the numbers");
  }
}

void LabCsvReader::select(std::vector<std::size_t> columns, bool first_is_time) {
  selected_ = std::move(columns);
  has_clock_ = false;
  if (!first_is_time || selected_.empty()) return;
  TextLine line = first_;
  while (text_.next_content(line) && line.begin < end_) {
    split_fields(line.text, shape_.separator, fields_);
    if (selected_[0] >= fields_.size() || !is_value(fields_[selected_[0]])) continue;
    has_clock_ = clock_time(fields_[selected_[0]]).has_value();
    return;
  }
}

std::vector<std::size_t> LabCsvReader::value_columns() const {
  std::vector<std::size_t> columns;
  for (std::size_t i = 0; i < shape_.width(); ++i)
    if (shape_.numbers[i]) columns.push_back(i);
  return columns;
}

void LabCsvReader::rewind() {
  line_ = first_;
  clock_ = {};
}

void LabCsvReader::damage(std::string_view at, std::string what) {
  if (!damage_) damage_ = Damage{at, std::move(what)};
}

double LabCsvReader::value(std::size_t i) {
  const std::size_t column = selected_[i];
  const std::string& stated = columns()[column].title;
  const auto title = [&] { return stated.empty() ? fmt::format("column {}", column + 1) : stated; };
  const std::string_view field =
      column < fields_.size() ? fields_[column] : line_.text.substr(line_.text.size());
  if (has_clock_ && i == 0) {
    if (const auto seconds = clock_.seconds(field)) return *seconds;
    damage(field, fmt::format("{} is \"{}\", expected a later time of day than in the row before", title(),
                              shortened(field)));
    return std::nan("");
  }
  const std::optional<double> value = signs_.number(field);
  if (value && std::isfinite(*value)) return *value;
  if (field.empty())
    damage(field, fmt::format("{} is empty, expected a number", title()));
  else
    damage(field, fmt::format("{} is \"{}\", expected a finite number", title(), shortened(field)));
  return std::nan("");
}

bool LabCsvReader::read(std::vector<double>& row) {
  damage_.reset();
  is_at_end_ = !text_.next_content(line_) || line_.begin >= end_;
  leaves_out_last_ = !is_at_end_ && line_.ends_the_file;
  is_at_end_ = is_at_end_ || leaves_out_last_;
  if (is_at_end_) return false;
  split_fields(line_.text, shape_.separator, fields_);
  if (!fits_width(fields_, shape_))
    damage(line_.text.substr(0, 0),
           fmt::format("the row has {}, expected {} as in {}", counted(fields_.size(), "field"),
                       shape_.width(), head_.has_names ? "the header" : "the other rows"));
  row.resize(selected_.size());
  for (std::size_t i = 0; i < selected_.size(); ++i) row[i] = value(i);
  return true;
}

std::string LabCsvReader::comment(std::string_view name) const { return comment_in(head_.comments, name); }

std::vector<std::string> LabCsvReader::notes() const {
  std::vector<std::string> notes;
  if (!signs_.note.empty()) notes.push_back(signs_.note);
  for (std::string& left_out : notes_of_end(leaves_out_last_, is_at_end_ ? text_.zeros() : 0))
    notes.push_back(std::move(left_out));
  if (is_at_end_ && has_foot_) notes.emplace_back("ignoring the text below the rows");
  return notes;
}

void LabCsvReader::fail_at_header(const std::string& what) const {
  throw Error({file(), head_.line, 1}, what);
}

}  // namespace hystcan::config
