#include "config/files/csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "base/input_file.h"
#include "base/text.h"
#include "controller/reference/motion.h"

namespace hystcan::config {
namespace {

// Returns TEXT of a line "# NAME = TEXT" with this name; empty if the line is different. TEXT may be in
// quotes.
std::string_view named_in_comment(std::string_view line, std::string_view name) {
  line = trimmed(line.substr(std::min(line.size(), line.find('#') + 1)));
  if (!line.starts_with(name)) return {};
  line = trimmed(line.substr(name.size()));
  if (!line.starts_with('=')) return {};
  line = trimmed(line.substr(1));
  if (line.size() >= 2 && line.front() == '"' && line.back() == '"') line = line.substr(1, line.size() - 2);
  return line;
}

std::unique_ptr<char[]> buffer_of_a_line() {
  return std::make_unique_for_overwrite<char[]>(longest_csv_line + 1);
}

/// Returns the position of the separator after the first field of the line; npos if no separator follows.
std::size_t end_of_field(std::string_view line, char separator) {
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (!quoted && (line[i] == separator || (separator == ' ' && line[i] == '\t'))) return i;
  }
  return quoted ? line.find(separator) : std::string_view::npos;  // an unclosed quote is a normal character
}

/// Reads a setpoint file. The file must be a regular file and not a pipe, because a running controller reads
/// it again. Adds a line end to the last row if it is missing.
std::string text_of_setpoint(const std::filesystem::path& file) {
  constexpr std::size_t largest = std::size_t{64} << 20U;  // 64 MiB
  std::string text = read_regular_file(file, largest, a_csv_file);
  if (!text.ends_with('\n')) text += '\n';
  return text;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

void split_fields(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  fields.clear();
  const bool plain = separator != ' ' && line.find('"') == std::string_view::npos;
  if (separator == ' ') line = trimmed(line);
  while (true) {
    const auto end = plain ? line.find(separator) : end_of_field(line, separator);
    const std::string_view field = trimmed(line.substr(0, end));
    // Constructs the element from pointer and size. Copying `field` would be slower: the copy would have to
    // wait until both members of `field` are stored.
    fields.emplace_back(field.data(), field.size());
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
    if (separator == ' ') line = trimmed(line);
  }
}

std::string_view unquoted(std::string_view text) {
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    return trimmed(text.substr(1, text.size() - 2));
  return text;
}

std::optional<double> csv_number(std::string_view text, bool decimal_comma) {
  text = unquoted(text);
  std::string with_point;
  if (decimal_comma && text.find(',') != std::string_view::npos) {
    with_point = text;
    std::ranges::replace(with_point, ',', '.');
    text = with_point;
  }
  return parsed_number<double>(text);
}

std::string in_one_line(std::string_view text) {
  std::string line(text);
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 0x20 || c == '\x7F') c = ' ';
  return line;
}

std::string csv_field(std::string_view text) {
  std::string field = in_one_line(text);
  if (field.find_first_of(",\"") == std::string::npos) return field;
  std::string quoted = "\"";
  for (const char c : field) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string comment_in(const std::vector<std::string>& comments, std::string_view name) {
  for (const std::string& line : comments)
    if (const std::string_view text = named_in_comment(line, name); !text.empty()) return std::string(text);
  return {};
}

std::string shortened(std::string_view text) {
  constexpr std::size_t most = 60;
  return text.size() <= most ? std::string(text) : fmt::format("{}...", text.substr(0, most));
}

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t most = 20;
  std::vector<std::string> shown;
  for (std::size_t i = 0; i < std::min(most, names.size()); ++i) shown.push_back(shortened(names[i]));
  const std::string more = names.size() > most ? fmt::format(" and {} more", names.size() - most) : "";
  return fmt::format("{}{}", fmt::join(shown, ", "), more);
}

std::vector<std::string> notes_of_end(bool is_cut, std::size_t zeros) {
  std::vector<std::string> notes;
  if (is_cut) notes.emplace_back("ignoring the last row: it has no line end and may be incomplete");
  if (zeros > 0) notes.push_back(fmt::format("ignoring {} at the end", counted(zeros, "zero byte")));
  return notes;
}

CsvLines::CsvLines(std::filesystem::path file)
    : file_(std::move(file)), stream_(open_input(file_, a_csv_file)), buffer_(buffer_of_a_line()) {}

CsvLines::CsvLines(std::filesystem::path file, std::string text)
    : file_(std::move(file)),
      stream_(std::make_unique<std::istringstream>(std::move(text))),
      buffer_(buffer_of_a_line()) {}

bool CsvLines::next() {
  while (read_line()) {
    const std::string_view text = trimmed(line_);
    const bool is_comment = text.starts_with('#');
    if (is_comment && keeps_comments_ && comments_.size() < most_comments && text.size() <= longest_comment)
      comments_.emplace_back(text);
    if (text.empty() || is_comment) continue;
    is_cut_ = ends_in_mid_line_ && has_content_;
    has_content_ = true;
    return !is_cut_;
  }
  return false;
}

bool CsvLines::read_line() {
  stream_->getline(buffer_.get(), longest_csv_line + 1);
  auto size = static_cast<std::size_t>(stream_->gcount());
  if (stream_->bad()) throw Error({file_, line_number_}, "cannot be read further");
  if (stream_->eof() && size == 0) return false;
  ends_in_mid_line_ = stream_->eof();
  ++line_number_;
  bytes_read_ += size;
  if (!stream_->eof() && !stream_->fail()) --size;  // gcount() also counts the line end
  line_ = {buffer_.get(), size};
  if (line_number_ == 1)
    if (const std::string_view other = refusal_of_encoding(line_); !other.empty()) fail(std::string(other));
  if (stream_->fail())
    fail(line_.substr(size),
         fmt::format("the line is too long, expected at most {} bytes", longest_csv_line));
  if (ends_in_mid_line_) {
    line_ = line_.substr(0, line_.find_last_not_of('\0') + 1);
    zeros_ = size - line_.size();
  }
  while (line_.ends_with('\r')) line_.remove_suffix(1);
  if (line_number_ == 1 && line_.starts_with(byte_order_mark))
    std::fill_n(buffer_.get(), byte_order_mark.size(), ' ');
  return true;
}

std::string CsvLines::comment(std::string_view name) const { return comment_in(comments_, name); }

void CsvLines::fail(std::string_view at, const std::string& what) const {
  const auto column = static_cast<std::size_t>(at.data() - line_.data());
  throw Error({file_, std::max<std::size_t>(line_number_, 1), column + 1}, what);
}

void require_width(const CsvLines& lines, std::size_t fields, std::size_t expected, char separator) {
  if (fields == expected) return;
  const bool commas = separator == ',' && fields == 2 * expected;
  lines.fail(fmt::format("the row has {}, expected {} as in the header{}", counted(fields, "field"), expected,
                         commas ? ": decimal commas need semicolons between the fields" : ""));
}

double finite_number(const CsvLines& lines, std::string_view field, const std::string& name, char separator) {
  if (field.empty()) lines.fail(field, fmt::format("{} is empty, expected a number", name));
  const std::optional<double> value = csv_number(field, separator != ',');
  if (!value || !std::isfinite(*value))
    lines.fail(field, fmt::format("{} is \"{}\", expected a finite number", name, shortened(field)));
  return *value;
}

CsvReader::CsvReader(CsvLines lines, std::vector<std::string> columns)
    : lines_(std::move(lines)), wanted_(std::move(columns)) {
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
      lines_.fail(
          fmt::format("no column {}, expected a column with this name among {}", name, listed(header_)));
  }
}

void CsvReader::require_distinct_columns() const {
  std::set<std::string_view> names;
  for (const std::string_view name : fields_)
    if (!names.insert(name).second)
      lines_.fail(name, fmt::format("column {} occurs twice, expected each name once", shortened(name)));
}

/// Returns the index of the column in header_; the size of header_ if the column is missing.
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

controller::MonotoneCubic load_setpoint(const std::filesystem::path& file) {
  CsvReader reader(CsvLines(file, text_of_setpoint(file)), {"time_s", "position_um"});
  std::vector<double> time_s;
  std::vector<double> position_um;
  std::vector<double> row;
  while (reader.next(row)) {
    if (!time_s.empty() && row[0] <= time_s.back())
      throw Error({file, reader.line_number(), 1},
                  fmt::format("time_s is {} after {}", row[0], time_s.back()), expect("an increasing time"));
    time_s.push_back(row[0]);
    position_um.push_back(row[1]);
  }
  if (time_s.size() < 2)
    throw Error({file, reader.line_number(), 1},
                fmt::format("the reference has {}", counted(time_s.size(), "row")), expect("at least two"));
  return {std::move(time_s), std::move(position_um)};
}

}  // namespace hystcan::config
