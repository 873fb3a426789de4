#include "can/dbc/cursor.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>

#include "can/dbc/database.h"

namespace hystcan::can::dbc {
namespace {

constexpr std::string_view blanks = " \t\r\n\f\v\x1A";  // Control-Z (0x1A) ends a DOS text file
constexpr std::string_view line_ends = "\r\n";

// clang-format off
constexpr std::array<std::string_view, 35> sections = {
    "VERSION", "NS_", "BS_", "BU_", "BO_", "SG_", "CM_", "VAL_TABLE_", "VAL_", "BA_DEF_", "BA_DEF_DEF_",
    "BA_", "BA_DEF_REL_", "BA_REL_", "BA_SGTYPE_", "EV_", "EV_DATA_", "ENVVAR_DATA_", "BO_TX_BU_",
    "SIG_GROUP_", "SG_MUL_VAL_", "SGTYPE_", "SGTYPE_VAL_", "SIG_TYPE_REF_", "SIGTYPE_VALTYPE_",
    "SIG_VALTYPE_", "CAT_DEF_", "CAT_", "FILTER", "BA_DEF_DEF_REL_", "BA_DEF_SGTYPE_", "BU_SG_REL_",
    "BU_EV_REL_", "BU_BO_REL_", "NS_DESC_"};
// clang-format on

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_of(std::string_view set, char c) { return set.find(c) != std::string_view::npos; }
bool is_identifier_part(char c) { return is_digit(c) || is_letter(c) || c == '_'; }
bool is_word_part(char c) {
  return is_identifier_part(c) || is_of("-.$#/", c) || static_cast<unsigned char>(c) >= 0x80;
}

bool names_no_finite_number(std::string_view word) {
  std::string small(word);
  std::transform(small.begin(), small.end(), small.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return small == "nan" || small == "inf" || small == "infinity";
}

std::string describe(const char* at, const char* end) {
  if (at == end) return "the end of the file";
  if (*at == '"' && std::find(at + 1, end, '"') == end) return "a string without an end";
  if (is_identifier_part(*at)) {
    const char* word_end = std::find_if_not(at, std::min(at + 40, end), is_identifier_part);
    return '\'' + std::string(at, word_end) + '\'';
  }
  if (*at >= ' ' && *at <= '~') return std::string("'") + *at + '\'';
  std::array<char, 12> byte{};
  std::snprintf(byte.data(), byte.size(), "byte 0x%02X",
                static_cast<unsigned>(static_cast<unsigned char>(*at)));
  return byte.data();
}

std::string_view bounded(std::string_view token, std::size_t longest) {
  if (token.size() <= longest) return token;
  throw ParseError{token.data(), std::to_string(token.size()) + " bytes",
                   "at most " + std::to_string(longest)};
}

}  // namespace

bool is_section(std::string_view word) {
  return std::find(sections.begin(), sections.end(), word) != sections.end();
}

bool looks_like_section(std::string_view word) {
  return word.size() > 2 && word.ends_with('_') && std::all_of(word.begin(), word.end(), [](char c) {
           return (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_';
         });
}

Cursor::Cursor(std::string_view text)
    : start_(text.data()), at_(text.data()), end_(text.data() + text.size()) {}

void Cursor::skip_blanks() {
  at_ = std::find_if_not(at_, end_, [](char c) { return is_of(blanks, c); });
}

bool Cursor::at_end() { return place() == end_; }

const char* Cursor::place() {
  skip_blanks();
  return at_;
}

bool Cursor::at_line_start() const {
  const char* before = at_;
  while (before != start_ && is_of(" \t", before[-1])) --before;
  return before == start_ || is_of(line_ends, before[-1]);
}

bool Cursor::is_word(std::string_view text) {
  Cursor cursor(text);
  return !text.empty() && cursor.peek_word() == text;
}

std::size_t Cursor::word_length() const {
  return static_cast<std::size_t>(std::find_if_not(at_, end_, is_word_part) - at_);
}

std::string_view Cursor::peek_word() {
  skip_blanks();
  if (at_ == end_ || (!is_identifier_part(*at_) && static_cast<unsigned char>(*at_) < 0x80)) return {};
  return {at_, word_length()};
}

std::optional<std::string_view> Cursor::take_word() {
  const std::string_view word = peek_word();
  if (word.empty()) return std::nullopt;
  at_ += word.size();
  return word;
}

std::optional<std::string_view> Cursor::take_number() {
  skip_blanks();
  const char* at = at_;
  const auto is_next = [&](std::string_view set) { return at != end_ && is_of(set, *at); };
  if (is_next("+-")) ++at;
  const char* const first = at;
  if (is_next("nNiI")) {
    at = std::find_if_not(at, end_, is_identifier_part);
    if (!names_no_finite_number({first, static_cast<std::size_t>(at - first)})) return std::nullopt;
    if (std::string_view(at, static_cast<std::size_t>(end_ - at)).starts_with("(ind)")) at += 5;
  } else if (is_next("0") && end_ - at > 2 && (at[1] == 'x' || at[1] == 'X')) {
    at = std::find_if_not(at + 2, end_, [](char c) { return std::isxdigit(static_cast<unsigned char>(c)); });
  } else {
    at = std::find_if_not(at, end_, is_digit);
    if (is_next(".")) at = std::find_if_not(at + 1, end_, is_digit);
    if (!std::any_of(first, at, is_digit)) return std::nullopt;
    if (is_next("#"))
      at = std::find_if_not(at + 1, end_, is_identifier_part);  // infinity or NaN: 1.#INF, 1.#QNAN
    if (is_next("eE")) {
      const char* exponent = at + 1;
      if (exponent != end_ && is_of("+-", *exponent)) ++exponent;
      if (exponent != end_ && is_digit(*exponent)) at = std::find_if_not(exponent, end_, is_digit);
    }
  }
  const std::string_view number(at_, static_cast<std::size_t>(at - at_));
  at_ = at;
  return number;
}

/// Returns true if a quote after a backslash ends the quoted text, for example "C:\". The quote ends the text
/// if it is followed by ';' and then by a section name on a new line, or by the end of the file.
bool Cursor::is_end_after_backslash(const char* after_quote) const {
  const auto skip = [this](const char* at, std::string_view set) {
    return std::find_if_not(at, end_, [&](char c) { return is_of(set, c); });
  };
  const char* at = skip(after_quote, " \t");
  if (at == end_ || *at != ';') return false;
  at = skip(at + 1, " \t");
  const char* const line_end = at;
  if (at != end_ && !is_of(line_ends, *at)) return false;
  at = skip(line_end, blanks);
  const char* word_end = std::find_if_not(at, end_, is_identifier_part);
  return at == end_ || is_section({at, static_cast<std::size_t>(word_end - at)});
}

const char* Cursor::end_of_quoted(const char* at) const {
  for (; at != end_; ++at) {
    if (*at == '"' && (at[-1] != '\\' || is_end_after_backslash(at + 1))) break;
  }
  return at;
}

std::optional<std::string_view> Cursor::take_quoted() {
  skip_blanks();
  if (at_ == end_ || *at_ != '"') return std::nullopt;
  const char* const close = end_of_quoted(at_ + 1);
  if (close == end_) return std::nullopt;
  const std::string_view text(at_ + 1, static_cast<std::size_t>(close - at_ - 1));
  at_ = close + 1;
  return text;
}

bool Cursor::take(char mark) {
  skip_blanks();
  if (at_ == end_ || *at_ != mark) return false;
  ++at_;
  return true;
}

std::string_view Cursor::need_word(const std::string& words) {
  if (const auto word = take_word()) return bounded(*word, longest_name);
  refuse(words);
}

std::string_view Cursor::need_number(const std::string& words) {
  if (const auto number = take_number()) return bounded(*number, longest_name);
  refuse(words);
}

std::string_view Cursor::need_quoted(const std::string& words, std::size_t longest) {
  if (const auto text = take_quoted()) return bounded(*text, longest);
  refuse(words);
}

void Cursor::need(char mark, const std::string& words) {
  if (!take(mark)) refuse(words);
}

void Cursor::refuse(const std::string& words) {
  skip_blanks();
  throw ParseError{at_, describe(at_, end_), words};
}

char Cursor::next() {
  skip_blanks();
  return at_ == end_ ? '\0' : *at_;
}

bool Cursor::next_is_digit() { return is_digit(next()); }

bool Cursor::next_is_on_this_line() {
  const char* at = std::find_if_not(at_, end_, [](char c) { return is_of(" \t\f\v", c); });
  return at != end_ && !is_of(line_ends, *at);
}

std::string_view Cursor::take_line() {
  const char* const first = at_;
  at_ = std::find_if(at_, end_, [](char c) { return is_of(line_ends, c); });
  return {first, static_cast<std::size_t>(at_ - first)};
}

void Cursor::take_any_of(std::string_view marks) {
  at_ = std::find_if_not(at_, end_, [&](char c) { return is_of(marks, c) || is_of(blanks, c); });
}

bool Cursor::take_until_semicolon() {
  while (!at_end()) {
    if (take(';')) return true;
    if (*at_ == '"') {
      if (!take_quoted()) refuse("a text in quotes");
    } else if (at_line_start() && is_section(peek_word())) {
      return false;
    } else if (!take_word()) {
      ++at_;
    }
  }
  return false;
}

}  // namespace hystcan::can::dbc
