#include "config/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace hystcan::config {
namespace {

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return text.substr(text.size());
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

void split(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  while (true) {
    const auto comma = line.find(',');
    fields.push_back(trim(line.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

CsvReader::CsvReader(std::filesystem::path file, std::vector<std::string> columns)
    : file_(std::move(file)), stream_(file_, std::ios::binary), wanted_(std::move(columns)) {
  if (!stream_ || std::filesystem::is_directory(file_))
    throw Error(fmt::format("{}: cannot be read, expected a CSV file", file_.string()));
  if (!next_line()) fail(0, "no header row, expected column names");
  for (const std::string& name : wanted_) {
    const auto found = std::ranges::find(fields_, name);
    if (found == fields_.end())
      fail(0, fmt::format("no column {}, expected it among {}", name, fmt::join(fields_, ", ")));
    where_.push_back(static_cast<std::size_t>(found - fields_.begin()));
  }
  width_ = fields_.size();
}

bool CsvReader::next(std::vector<double>& row) {
  if (!next_line()) return false;
  if (fields_.size() != width_)
    fail(0, fmt::format("the row has {} fields, expected {} as in the header", fields_.size(), width_));
  row.resize(wanted_.size());
  for (std::size_t i = 0; i < wanted_.size(); ++i) row[i] = number(where_[i], wanted_[i]);
  return true;
}

bool CsvReader::has_column(const std::filesystem::path& file, std::string_view column) {
  CsvReader reader(file, {});
  return std::ranges::find(reader.fields_, column) != reader.fields_.end();
}

/// The next line that says something, split into fields.
bool CsvReader::next_line() {
  while (std::getline(stream_, line_)) {
    ++line_number_;
    if (line_.ends_with('\r')) line_.pop_back();
    if (trim(line_).empty() || line_.starts_with('#')) continue;
    split(line_, fields_);
    return true;
  }
  if (stream_.bad()) throw Error(fmt::format("{}:{}: cannot be read further", file_.string(), line_number_));
  return false;
}

double CsvReader::number(std::size_t column, const std::string& name) const {
  const std::string_view text = fields_[column];
  const auto start = static_cast<std::size_t>(text.data() - line_.data());
  if (text.empty()) fail(start, fmt::format("{} is empty, expected a number", name));
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    fail(start, fmt::format("{} is \"{}\", expected a finite number", name, text));
  return value;
}

void CsvReader::fail(std::size_t column_start, const std::string& what) const {
  throw Error(fmt::format("{}:{}:{}: {}", file_.string(), std::max<std::size_t>(line_number_, 1),
                          column_start + 1, what));
}

}  // namespace hystcan::config
