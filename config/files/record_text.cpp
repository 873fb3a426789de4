#include "config/files/record_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <istream>
#include <memory>
#include <utility>

#include "base/error.h"
#include "base/input_file.h"
#include "base/text.h"
#include "config/files/csv.h"

namespace hystcan::config {
namespace {

struct Kind {
  std::string_view begin;
  std::string_view found;
};
/// File formats that can't be read, with the first bytes that identify each format. The error message
/// contains the name of the format.
constexpr std::array<Kind, 9> other_kinds{{{"PK\x03\x04", "an Excel file or another archive"},
                                           {"\xD0\xCF\x11\xE0", "an old Excel file"},
                                           {"\x89HDF", "an HDF5 or MATLAB file"},
                                           {"MATLAB 5.0", "a MATLAB file"},
                                           {"TDSm", "a TDMS file of LabVIEW"},
                                           {"PAR1", "a Parquet file"},
                                           {"\x93NUMPY", "a file of numpy.save"},
                                           {"\x1F\x8B", "a compressed file"},
                                           {"%PDF", "a PDF"}}};

}  // namespace

bool TextLine::is_blank() const { return trimmed(text).empty(); }
bool TextLine::is_comment() const { return trimmed(text).starts_with('#'); }

RecordText::RecordText(std::filesystem::path file, std::size_t most_lines) : file_(std::move(file)) {
  read(most_lines);
  const std::size_t last = text_.find_last_not_of('\0');
  const std::size_t size = last == std::string::npos ? 0 : last + 1;
  zeros_ = text_.size() - size;
  text_.resize(size);
}

void RecordText::read(std::size_t most_lines) {
  const std::unique_ptr<std::istream> stream = open_input(file_, a_csv_file);
  std::error_code unknown;
  const auto size = std::filesystem::file_size(file_, unknown);
  const bool is_regular = !unknown && size > 0;
  const std::size_t block = is_regular ? std::min<std::uintmax_t>(size + 1, 1U << 20U) : 1U << 16U;
  if (is_regular) text_.reserve(std::min<std::uintmax_t>(size + block, std::uintmax_t{1} << 32U));
  std::size_t lines = 0, line_begin = 0;
  while (true) {
    const std::size_t begin = text_.size();
    text_.resize(begin + block);
    stream->read(text_.data() + begin, static_cast<std::streamsize>(block));
    text_.resize(begin + static_cast<std::size_t>(stream->gcount()));
    if (stream->bad()) throw Error({file_, lines + 1}, "cannot be read further");
    if (text_.size() == begin) return;
    if (begin == 0) refuse_other_kinds();
    lines += static_cast<std::size_t>(
        std::count(text_.begin() + static_cast<std::ptrdiff_t>(begin), text_.end(), '\n'));
    if (lines > most_lines)
      throw Error({file_, lines, 1}, "too many lines", expect("at most {}", most_lines));
    // Refuses a line longer than longest_csv_line. The rest of such a line is not read into memory.
    const std::size_t end = text_.rfind('\n');
    if (end != std::string::npos && end >= begin) line_begin = end + 1;
    if (text_.size() - line_begin > longest_csv_line)
      throw Error({file_, lines + 1, longest_csv_line + 1}, "the line is too long",
                  expect("at most {} bytes", longest_csv_line));
  }
}

void RecordText::refuse_other_kinds() const {
  for (const Kind& kind : other_kinds)
    if (text_.starts_with(kind.begin))
      throw Error({file_, 1, 1}, fmt::format("this is {}", kind.found), expect("text: save the file as CSV"));
  if (const std::string_view other = refusal_of_encoding(text_); !other.empty())
    throw Error({file_, 1, 1}, other);
}

bool RecordText::next(TextLine& line) const {
  if (line.next >= text_.size()) return false;
  line.begin = line.next;
  const std::size_t end = text_.find('\n', line.begin);
  line.ends_the_file = end == std::string::npos;
  line.next = line.ends_the_file ? text_.size() : end + 1;
  line.text = std::string_view(text_).substr(line.begin, end - line.begin);
  while (line.text.ends_with('\r')) line.text.remove_suffix(1);
  if (++line.number == 1) line.text = without_byte_order_mark(line.text);
  return true;
}

bool RecordText::next_content(TextLine& line) const {
  while (next(line)) {
    const std::size_t first = line.text.find_first_not_of(" \t");
    if (first != std::string_view::npos && line.text[first] != '#') return true;
  }
  return false;
}

Place RecordText::place(const TextLine& line, std::string_view at) const {
  const std::size_t column =
      at.data() >= text_.data() + line.begin && at.data() <= text_.data() + text_.size()
          ? static_cast<std::size_t>(at.data() - text_.data()) - line.begin
          : 0;
  return {file_, std::max<std::size_t>(line.number, 1), column + 1};
}

void RecordText::fail(const TextLine& line, std::string_view at, const std::string& what) const {
  throw Error(place(line, at), what);
}

}  // namespace hystcan::config
