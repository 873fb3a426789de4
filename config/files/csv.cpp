#include "config/files/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace hystcan::config {

CsvReader::CsvReader(std::filesystem::path file, std::vector<std::string> columns)
    : lines_(std::move(file)), wanted_(std::move(columns)) {
  read_header();
}

CsvReader::CsvReader(std::filesystem::path file, std::string text, std::vector<std::string> columns)
    : lines_(std::move(file), std::move(text)), wanted_(std::move(columns)) {
  read_header();
}

void CsvReader::read_header() {
  if (!lines_.next()) lines_.fail("no header row, expected column names");
  lines_.end_comments();
  for (const char separator : {';', '\t'})
    if (lines_.text().find(',') == std::string::npos && lines_.text().find(separator) != std::string::npos) {
      separator_ = separator;
      break;
    }
  split_fields(lines_.text(), separator_, fields_);
  if (fields_.size() > most_columns)
    lines_.fail(fmt::format("{} columns, expected at most {}", fields_.size(), most_columns));
  header_.assign(fields_.begin(), fields_.end());
  require_distinct_columns();
  for (const std::string& name : wanted_) {
    where_.push_back(look_up(name));
    if (where_.back() == header_.size())
      lines_.fail(fmt::format("no column {}, expected it among {}", name, listed(header_)));
  }
}

void CsvReader::require_distinct_columns() const {
  std::set<std::string_view> names;
  for (const std::string_view name : fields_)
    if (!names.insert(name).second)
      lines_.fail(name, fmt::format("column {} occurs twice, expected each name once", shortened(name)));
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

bool CsvReader::next(std::vector<double>& row) {
  if (!lines_.next()) return false;
  split_fields(lines_.text(), separator_, fields_);
  require_width(lines_, fields_.size(), header_.size(), separator_);
  row.resize(wanted_.size());
  for (std::size_t i = 0; i < wanted_.size(); ++i)
    row[i] = finite_number(lines_, fields_[where_[i]], wanted_[i], separator_);
  return true;
}

}  // namespace hystcan::config
