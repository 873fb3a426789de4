#include "config/document/toml_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/text.h"

namespace hystcan::config {
namespace {

bool is_ascii(char c) { return static_cast<unsigned char>(c) < 0x80; }

/// Returns the position after the TOML string that begins at `at`, or the end of the text if the string does
/// not end. The content of a multi-line string may end with two quotes, directly before the three closing
/// quotes.
std::size_t end_of_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const auto run = [&](std::size_t from) {
    std::size_t length = 0;
    while (length < 5 && from + length < text.size() && text[from + length] == quote) ++length;
    return length;
  };
  const bool multi_line = run(at) >= 3;
  for (at += multi_line ? 3 : 1; at < text.size(); ++at) {
    if (text[at] == '\\' && quote == '"') {
      ++at;
    } else if (text[at] == '\n' && !multi_line) {
      return at;  // the TOML library rejects a line end in a single-line string
    } else if (text[at] == quote) {
      const std::size_t length = run(at);
      if (!multi_line) return at + 1;
      if (length >= 3) return at + length;
      at += length - 1;
    }
  }
  return text.size();
}

/// Checks a TOML text for content that the TOML library can't parse safely. The caller passes the text in
/// order: each string and each comment as a whole, the rest character by character.
class Scan {
 public:
  /// Checks the next character outside strings and comments. Returns a description of the problem, or null.
  const char* add(char c) {
    constexpr std::string_view before_a_value = " \t\r\n=,[{";
    constexpr std::string_view behind_a_number = " \t\r\n,]}";
    constexpr std::string_view digits_and_signs = "0123456789+-";
    if (!is_ascii(c)) return "a character outside ASCII that is not in a string";
    if (behind_a_number.find(c) != std::string_view::npos)
      in_number_ = false;
    else if (before_a_value.find(last_) != std::string_view::npos)
      in_number_ = in_number_ || digits_and_signs.find(c) != std::string_view::npos;
    last_ = c;
    return count(c);
  }
  void add_comment() { in_number_ = false; }
  /// Checks a TOML string. Returns a description of the problem, or null. The TOML library does not check the
  /// characters of two texts: the white space after a backslash in a multi-line string, and the text between
  /// a number and the next separator. This function must therefore find wrong characters there.
  const char* add_string(std::string_view string) {
    if (in_number_) return "a string directly after a number";
    last_ = string.front();
    if (string.starts_with("\"\"\"") && !std::ranges::all_of(string, is_ascii))
      return "a multi-line string with a character outside ASCII";
    return nullptr;
  }

 private:
  const char* count(char c) {
    if (c == '[' || c == '{') ++depth_;
    if ((c == ']' || c == '}') && depth_ > 0) --depth_;
    if (c == '.') ++dots_;
    if (std::string_view("\n,=[]{}").find(c) != std::string_view::npos) dots_ = 0;
    if (depth_ > deepest_nesting) return "more than 16 open brackets";
    if (dots_ >= most_key_parts) return "a key of more than 16 parts";
    return nullptr;
  }

  char last_ = '\n';
  bool in_number_ = false;
  std::size_t depth_ = 0;
  std::size_t dots_ = 0;
};
static_assert(deepest_nesting == 16 && most_key_parts == 16, "as the messages say");

Place place_of(std::string_view text, std::size_t at, const std::string& name) {
  const std::string_view before = text.substr(0, at);
  const std::size_t line_start = before.rfind('\n') + 1;  // in the first line, rfind() + 1 is 0
  return {name, static_cast<std::size_t>(std::ranges::count(before, '\n')) + 1, at - line_start + 1};
}

}  // namespace

void refuse_hostile_toml(std::string_view text, const std::string& name) {
  Scan scan;
  for (std::size_t at = text.size() - without_byte_order_mark(text).size(); at < text.size();) {
    std::size_t next = at + 1;
    const char* wrong = nullptr;
    if (text[at] == '#') {
      scan.add_comment();
      next = std::min(text.find('\n', at), text.size());
    } else if (text[at] == '"' || text[at] == '\'') {
      next = end_of_string(text, at);
      wrong = scan.add_string(text.substr(at, next - at));
    } else {
      wrong = scan.add(text[at]);
    }
    if (wrong != nullptr) throw Error(place_of(text, at, name), wrong, expect("TOML"));
    at = next;
  }
}

std::string toml_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7F) {
      result += fmt::format("\\u{:04X}", byte);
    } else {
      if (c == '"' || c == '\\') result += '\\';
      result += c;
    }
  }
  return result + '"';
}

std::string toml_comment(std::string_view lines) {
  std::string comment = "# ";
  for (const char c : lines) {
    comment += c != '\n' && has_control_character({&c, 1}) ? ' ' : c;
    if (c == '\n') comment += "# ";
  }
  comment.resize(comment.size() - 2);
  return comment;
}

toml::table parse_toml(std::string_view text, const std::string& name, std::string_view origin) {
  if (const std::string_view other = refusal_of_encoding(text); !other.empty())
    throw Error({name, 1, 1}, other);
  refuse_hostile_toml(text, name);
  try {
    return origin.empty() ? toml::parse(text) : toml::parse(text, origin);
  } catch (const toml::parse_error& error) {
    const toml::source_position place = error.source().begin;
    throw Error({name, place.line, place.column}, error.description(), expect("TOML"));
  }
}

}  // namespace hystcan::config
