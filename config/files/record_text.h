// The text of a measured record in memory, line by line.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/error.h"

namespace hystcan::config {

struct TextLine {
  std::string_view text{};     ///< the line without its line end
  std::size_t number = 0;      ///< line number, from 1; 0 before the first line
  std::size_t begin = 0;       ///< offset of the line in the text
  std::size_t next = 0;        ///< offset of the next line
  bool ends_the_file = false;  ///< the line has no line end: it may be incomplete

  bool is_blank() const;
  bool is_comment() const;  ///< begins with #
};

class RecordText {
 public:
  /// The file may be a pipe (base/input_file.h). Throws Error if it can't be read, if it is not UTF-8 text,
  /// if a line is longer than longest_csv_line, or if it has more than `most_lines`.
  RecordText(std::filesystem::path file, std::size_t most_lines);

  const std::filesystem::path& file() const { return file_; }
  std::string_view text() const { return text_; }
  /// The number of omitted zeros at the end; a file system writes them after a power failure.
  std::size_t zeros() const { return zeros_; }
  /// Replaces a line by the next line; start with TextLine{}. Returns false at the end.
  bool next(TextLine& line) const;
  /// Like next(), but skips blank lines and comments.
  bool next_content(TextLine& line) const;

  /// Returns the place of `at`, which points into the line.
  Place place(const TextLine& line, std::string_view at) const;
  /// Throws Error with the place; `at` points into the line.
  [[noreturn]] void fail(const TextLine& line, std::string_view at, const std::string& what) const;

 private:
  void read(std::size_t most_lines);
  void refuse_other_kinds() const;

  std::filesystem::path file_;
  std::string text_;
  std::size_t zeros_ = 0;
};

}  // namespace hystcan::config
