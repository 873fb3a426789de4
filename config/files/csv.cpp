#include "config/files/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>
#include <utility>

#include "can/counted.h"
#include "can/input_stream.h"
#include "can/regular_file.h"

namespace hystcan::config {
namespace {

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return text.substr(text.size());
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

void split(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  fields.clear();
  while (true) {
    const auto end = line.find(separator);
    fields.push_back(trim(line.substr(0, end)));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

// Parses "# NAME = TEXT"; TEXT may be in quotes.
std::string_view named_in_comment(std::string_view line, std::string_view name) {
  line = trim(line.substr(std::min(line.size(), line.find('#') + 1)));
  if (!line.starts_with(name)) return {};
  line = trim(line.substr(name.size()));
  if (!line.starts_with('=')) return {};
  line = trim(line.substr(1));
  if (line.size() >= 2 && line.front() == '"' && line.back() == '"') line = line.substr(1, line.size() - 2);
  return line;
}

std::string shortened(std::string_view text) {
  constexpr std::size_t most = 60;
  return text.size() <= most ? std::string(text) : fmt::format("{}...", text.substr(0, most));
}

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t most = 20;
  std::vector<std::string> some;
  for (std::size_t i = 0; i < std::min(most, names.size()); ++i) some.push_back(shortened(names[i]));
  const std::string more = names.size() > most ? fmt::format(" and {} more", names.size() - most) : "";
  return fmt::format("{}{}", fmt::join(some, ", "), more);
}

std::unique_ptr<std::istream> open_csv(const std::filesystem::path& file) {
  try {
    return can::open_input(file);
  } catch (const can::FileError& error) {
    throw Error(fmt::format("{}: cannot be read: {}, expected a CSV file", file.string(), error.what()));
  }
}

std::unique_ptr<char[]> buffer_of_a_line() {
  return std::make_unique_for_overwrite<char[]>(longest_csv_line + 1);
}

}  // namespace

CsvReader::CsvReader(std::filesystem::path file, std::vector<std::string> columns)
    : file_(std::move(file)),
      stream_(open_csv(file_)),
      wanted_(std::move(columns)),
      buffer_(buffer_of_a_line()) {
  read_header();
}

CsvReader::CsvReader(std::filesystem::path file, std::string text, std::vector<std::string> columns)
    : file_(std::move(file)),
      stream_(std::make_unique<std::istringstream>(std::move(text))),
      wanted_(std::move(columns)),
      buffer_(buffer_of_a_line()) {
  read_header();
}

void CsvReader::read_header() {
  if (!next_line()) fail(0, "no header row, expected column names");
  for (const char separator : {';', '\t'}) {
    if (line_.find(',') != std::string::npos || line_.find(separator) == std::string::npos) continue;
    separator_ = separator;
    split(line_, separator_, fields_);
    break;
  }
  if (fields_.size() > most_columns)
    fail(0, fmt::format("{} columns, expected at most {}", fields_.size(), most_columns));
  header_.assign(fields_.begin(), fields_.end());
  require_distinct_columns();
  for (const std::string& name : wanted_) {
    where_.push_back(look_up(name));
    if (where_.back() == header_.size())
      fail(0, fmt::format("no column {}, expected it among {}", name, listed(header_)));
  }
}

void CsvReader::require_distinct_columns() const {
  std::set<std::string_view> names;
  for (const std::string_view name : fields_)
    if (!names.insert(name).second)
      fail(static_cast<std::size_t>(name.data() - line_.data()),
           fmt::format("column {} occurs twice, expected each name once", shortened(name)));
}

/// The index of the column in the header; the header's size if it is not there.
std::size_t CsvReader::look_up(const std::string& column) const {
  return static_cast<std::size_t>(std::ranges::find(header_, column) - header_.begin());
}

bool CsvReader::add_if_present(const std::string& column) {
  const std::size_t where = look_up(column);
  if (where == header_.size()) return false;
  wanted_.push_back(column);
  where_.push_back(where);
  return true;
}

std::string CsvReader::comment(std::string_view name) const {
  for (const std::string& line : comments_)
    if (const std::string_view text = named_in_comment(line, name); !text.empty()) return std::string(text);
  return {};
}

bool CsvReader::next(std::vector<double>& row) {
  if (!next_line()) return false;
  if (fields_.size() != header_.size()) {
    const bool cut = ends_in_mid_line() && fields_.size() < header_.size();
    const bool commas = separator_ == ',' && fields_.size() == 2 * header_.size();
    fail(0, fmt::format("the row has {}{}, expected {} as in the header{}",
                        can::counted(fields_.size(), "field"), cut ? " and then the file ends" : "",
                        header_.size(),
                        commas ? ": decimal commas are read where semicolons stand between the fields" : ""));
  }
  row.resize(wanted_.size());
  for (std::size_t i = 0; i < wanted_.size(); ++i) row[i] = number(where_[i], wanted_[i]);
  return true;
}

/// Reads the next line that is neither empty nor a comment, and splits it into fields.
bool CsvReader::next_line() {
  while (read_line()) {
    const std::string_view text = trim(line_);
    const bool is_comment = text.starts_with('#');
    if (is_comment && header_.empty() && comments_.size() < most_comments && text.size() <= longest_comment)
      comments_.emplace_back(text);
    if (text.empty() || is_comment) continue;
    split(line_, separator_, fields_);
    return true;
  }
  return false;
}

/// Reads a line without its end and without Excel's mark of the byte order; false at the end of the file.
bool CsvReader::read_line() {
  stream_->getline(buffer_.get(), longest_csv_line + 1);
  auto size = static_cast<std::size_t>(stream_->gcount());
  if (stream_->bad()) throw Error(fmt::format("{}:{}: cannot be read further", file_.string(), line_number_));
  if (stream_->eof() && size == 0) return false;
  ++line_number_;
  bytes_read_ += size;
  if (stream_->fail())
    fail(longest_csv_line, fmt::format("a longer line, expected at most {} bytes", longest_csv_line));
  if (!stream_->eof()) --size;  // the end of the line is counted too
  line_ = {buffer_.get(), size};
  if (line_.ends_with('\r')) line_.remove_suffix(1);
  if (line_number_ == 1 && line_.starts_with("\xEF\xBB\xBF")) std::fill_n(buffer_.get(), 3, ' ');
  return true;
}

double CsvReader::number(std::size_t column, const std::string& name) const {
  const std::string_view text = fields_[column];
  const auto start = static_cast<std::size_t>(text.data() - line_.data());
  if (text.empty()) fail(start, fmt::format("{} is empty, expected a number", name));
  std::string with_point;
  std::string_view digits = text;
  if (separator_ != ',' && text.find(',') != std::string_view::npos) {
    with_point = text;
    std::ranges::replace(with_point, ',', '.');
    digits = with_point;
  }
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  double value = 0.0;
  const char* last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data(), last, value);
  if (error != std::errc() || end != last || !std::isfinite(value))
    fail(start, fmt::format("{} is \"{}\", expected a finite number", name, shortened(text)));
  return value;
}

void CsvReader::fail(std::size_t column_start, const std::string& what) const {
  throw Error(fmt::format("{}:{}:{}: {}", file_.string(), std::max<std::size_t>(line_number_, 1),
                          column_start + 1, what));
}

}  // namespace hystcan::config
