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

/// Reads the text of a DBC token by token. The cursor moves only forward, so that the reading time is
/// proportional to the text length. `take_...` leaves the cursor at its place if the token is missing.
/// `need_...` throws a ParseError if the token is missing or too long; `words` describes the expected token.
/// A returned token is a view into the text.
class Cursor {
 public:
  explicit Cursor(std::string_view text);

  /// Returns true if take_word() would take the whole text as one word.
  static bool is_word(std::string_view text);

  bool at_end();               ///< true if only blanks are left in the text
  bool at_line_start() const;  ///< true if only blanks are between the start of the line and the cursor
  const char* place();         ///< skips blanks; returns the position of the next token

  std::optional<std::string_view>
  take_word();  ///< takes a word: letters, digits, '_', and other characters that tools put into names
  std::optional<std::string_view>
  take_number();  ///< takes a decimal or hexadecimal (0x1F) number, or a name of infinity or NaN
  std::optional<std::string_view> take_quoted();  ///< takes a quoted text (it may contain \"); returns it
                                                  ///< without its quotes
  bool take(char mark);
  std::string_view peek_word();  ///< returns the next word without taking it; empty if no word is next

  std::string_view need_word(const std::string& words);
  std::string_view need_number(const std::string& words);
  std::string_view need_quoted(const std::string& words, std::size_t longest);
  void need(char mark, const std::string& words);
  [[noreturn]] void refuse(const std::string& words);

  char next();  ///< returns the next character that is not a blank, without taking it; 0 at the end
  bool next_is_digit();
  bool next_is_on_this_line();               ///< true if the line has a token after the cursor
  std::string_view take_line();              ///< takes everything up to the end of the line
  void take_any_of(std::string_view marks);  ///< takes all following blanks and characters of `marks`
  bool take_until_semicolon();  ///< takes everything up to the next ';' that is not in quotes; returns
                                ///< false if a section name or the end of the text is before this ';'

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
