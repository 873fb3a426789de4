// Holds the text of a measured record in memory and returns it line by line.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/error.h"

namespace hystcan::config {

struct TextLine {
  std::string_view text{};     ///< the line without its line end
  std::size_t number = 0;      ///< line number, from 1; 0: before the first line
  std::size_t begin = 0;       ///< offset of the line in the text
  std::size_t next = 0;        ///< offset of the next line
  bool ends_the_file = false;  ///< the line has no line end: it may be incomplete

  bool is_blank() const;
  bool is_comment() const;  ///< returns true if the line begins with #
};

class RecordText {
 public:
  /// Reads the file, which may be a pipe (base/input_file.h). Throws Error if the file can't be read, is not
  /// UTF-8 text, has a line longer than longest_csv_line, or has more than `most_lines` lines.
  RecordText(std::filesystem::path file, std::size_t most_lines);

  const std::filesystem::path& file() const { return file_; }
  std::string_view text() const { return text_; }
  /// Returns the number of zero bytes at the end of the file, which are not part of text(). A power failure
  /// can leave such zero bytes.
  std::size_t zeros() const { return zeros_; }
  /// Moves `line` to the next line of the text. A default TextLine{} moves to the first line. Returns false
  /// at the end of the text.
  bool next(TextLine& line) const;
  /// Sets `line` to the next line that is neither blank nor a comment. Returns false at the end of the text.
  bool next_content(TextLine& line) const;

  /// Returns file, line and column of `at`, a part of the line.
  Place place(const TextLine& line, std::string_view at) const;
  /// Throws Error with the message `what` and the place of `at`, a part of the line.
  [[noreturn]] void fail(const TextLine& line, std::string_view at, const std::string& what) const;

 private:
  void read(std::size_t most_lines);
  void refuse_other_kinds() const;

  std::filesystem::path file_;
  std::string text_;
  std::size_t zeros_ = 0;
};

}  // namespace hystcan::config
