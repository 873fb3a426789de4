// A position in the text of a DBC. Its functions take one token at a time.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace hystcan::can::dbc {

/// The first place at which the text is not a valid DBC.
struct ParseError {
  const char* where;
  std::string found;
  std::string expected;
};

/// The cursor moves only forward: reading is linear in the text. `take_...` does not move if the token is
/// missing; `need_...` throws a ParseError with `words` as the expected token if the token is missing or too
/// long. A token is a view into the text.
class Cursor {
 public:
  explicit Cursor(std::string_view text);

  /// Returns true if take_word() would take the whole text as one word.
  static bool is_word(std::string_view text);

  bool at_end();               ///< only blanks are left
  bool at_line_start() const;  ///< only blanks are between the start of the line and the cursor
  const char* place();         ///< position of the next token

  std::optional<std::string_view>
  take_word();  ///< a word: letters, digits, '_', and other characters that tools put into names
  std::optional<std::string_view>
  take_number();  ///< a decimal or hexadecimal (0x1F) number, or a name of infinity or NaN
  std::optional<std::string_view> take_quoted();  ///< the text without its quotes; \" does not end the text
  bool take(char mark);
  std::string_view peek_word();  ///< empty if the next token is not a word

  std::string_view need_word(const std::string& words);
  std::string_view need_number(const std::string& words);
  std::string_view need_quoted(const std::string& words, std::size_t longest);
  void need(char mark, const std::string& words);
  [[noreturn]] void refuse(const std::string& words);

  char next();  ///< the next character; 0 at the end of the text
  bool next_is_digit();
  bool next_is_on_this_line();               ///< true if the line has a token after the cursor
  std::string_view take_line();              ///< takes everything up to the end of the line
  void take_any_of(std::string_view marks);  ///< takes characters of the set and blanks
  bool take_until_semicolon();  ///< skips each string as a whole; false if a section or the end of the text
                                ///< precedes the semicolon

 private:
  void skip_blanks();
  std::size_t word_length() const;
  const char* end_of_quoted(const char* at) const;
  bool is_end_after_backslash(const char* after_quote) const;

  const char* start_;
  const char* at_;
  const char* end_;
};

/// Returns true if the word begins a section of the format.
bool is_section(std::string_view word);

/// Returns true if the word has the form of a section name (example: FOO_).
bool looks_like_section(std::string_view word);

}  // namespace hystcan::can::dbc
