// A place in the text of a DBC, and the tokens that can be taken from it.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "can/dbc/grammar.h"

namespace hystcan::can::dbc {

/// Moves forward only, so that reading is linear in the text. `take_...` leaves the place as it is where the
/// token does not stand there; `need_...` throws a ParseError in the words given.
class Cursor {
 public:
  explicit Cursor(std::string_view text);

  bool at_end();               ///< nothing but blanks is left
  bool at_line_start() const;  ///< only blanks stand before, since the last line end
  const char* place();         ///< of the next token

  std::optional<Token> take_word();    ///< letters, digits, '_', and what careless tools put into names
  std::optional<Token> take_number();  ///< decimal, hexadecimal (0x1F), and the names of what is not finite
  std::optional<Token> take_quoted();  ///< without its quotes; \" does not end it
  bool take(char mark);
  bool take_keyword(std::string_view word);
  Token peek_word();  ///< empty where no word stands next

  Token need_word(const std::string& words);
  Token need_number(const std::string& words);
  Token need_quoted(const std::string& words);
  void need(char mark, const std::string& words);
  [[noreturn]] void refuse(const std::string& words);

  char next();  ///< the next character, 0 at the end
  bool next_is_digit();
  bool next_is_on_this_line();               ///< before the line ends, blanks left out
  std::string_view take_line();              ///< up to the line's end
  void take_any_of(std::string_view marks);  ///< characters of the set, and blanks
  bool take_until_semicolon();  ///< strings skipped whole; false where a section or the end comes first

 private:
  void skip_blanks();
  std::size_t word_length() const;
  const char* end_of_quoted(const char* at) const;
  bool is_end_after_backslash(const char* after_quote) const;

  const char* start_;
  const char* at_;
  const char* end_;
};

/// Whether this word begins a section that the format knows.
bool is_section(std::string_view word);

/// Whether it looks as one would: FOO_.
bool looks_like_section(std::string_view word);

}  // namespace hystcan::can::dbc
