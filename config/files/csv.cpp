#include "config/files/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "can/counted.h"

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

/// A device may never end, nor end a line.
std::unique_ptr<std::istream> open_csv(const std::filesystem::path& file) {
  const auto refuse = [&](const std::string& reason) {
    throw Error(fmt::format("{}: cannot be read: {}, expected a CSV file", file.string(), reason));
  };
  std::error_code ignored;
  const auto type = std::filesystem::status(file, ignored).type();
  if (type == std::filesystem::file_type::character) refuse("it is a device");
  if (type == std::filesystem::file_type::directory) refuse(std::generic_category().message(EISDIR));
  auto stream = std::make_unique<std::ifstream>(file, std::ios::binary);
  if (!*stream) refuse(std::generic_category().message(errno));
  return stream;
}

}  // namespace

CsvReader::CsvReader(std::filesystem::path file, std::vector<std::string> columns)
    : file_(std::move(file)), stream_(open_csv(file_)), wanted_(std::move(columns)) {
  read_header();
}

CsvReader::CsvReader(std::filesystem::path file, std::string text, std::vector<std::string> columns)
    : file_(std::move(file)),
      stream_(std::make_unique<std::istringstream>(std::move(text))),
      wanted_(std::move(columns)) {
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
  header_.assign(fields_.begin(), fields_.end());
  for (std::size_t i = 0; i < header_.size(); ++i)
    if (look_up(header_[i]) != i)
      fail(static_cast<std::size_t>(fields_[i].data() - line_.data()),
           fmt::format("column {} occurs twice, expected each name once", header_[i]));
  for (const std::string& name : wanted_) {
    where_.push_back(look_up(name));
    if (where_.back() == header_.size())
      fail(0, fmt::format("no column {}, expected it among {}", name, fmt::join(header_, ", ")));
  }
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
  while (std::getline(*stream_, line_)) {
    ++line_number_;
    bytes_read_ += line_.size() + 1;
    if (line_.ends_with('\r')) line_.pop_back();
    if (line_number_ == 1 && line_.starts_with("\xEF\xBB\xBF"))
      line_.replace(0, 3, "   ");  // Excel's mark of the byte order
    if (trim(line_).starts_with('#') && header_.empty()) comments_.push_back(line_);
    if (trim(line_).empty() || trim(line_).starts_with('#')) continue;
    split(line_, separator_, fields_);
    return true;
  }
  if (stream_->bad()) throw Error(fmt::format("{}:{}: cannot be read further", file_.string(), line_number_));
  return false;
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
    fail(start, fmt::format("{} is \"{}\", expected a finite number", name, text));
  return value;
}

void CsvReader::fail(std::size_t column_start, const std::string& what) const {
  throw Error(fmt::format("{}:{}:{}: {}", file_.string(), std::max<std::size_t>(line_number_, 1),
                          column_start + 1, what));
}

}  // namespace hystcan::config
