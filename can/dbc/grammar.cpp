#include "can/dbc/grammar.h"

#include <algorithm>
#include <utility>

#include "can/dbc/cursor.h"

namespace hystcan::can::dbc {
namespace {

constexpr const char* semicolon = "';' at the end of the section";
constexpr const char* colon = "':' after the section's name";
constexpr const char* message_id = "the identifier of a message";
constexpr const char* signal_name = "the name of a signal";
constexpr const char* quoted_text = "a text in quotes";

/// One function for each section. Each starts with the cursor after the section's name.
class Parser {
 public:
  explicit Parser(std::string_view text) : cursor_(text) {}

  Document run() {
    if (cursor_.at_end()) cursor_.refuse("a DBC, which begins with VERSION, NS_, BS_, BU_ or BO_");
    for (bool first = true; !cursor_.at_end(); first = false) {
      if (!section()) {
        cursor_.refuse(first ? "a DBC, which begins with VERSION, NS_, BS_, BU_ or BO_"
                             : "a section of a DBC, such as BO_, CM_ or VAL_");
      }
    }
    return std::move(document_);
  }

 private:
  bool section() {
    struct Section {
      std::string_view keyword;
      void (Parser::*parse)();
    };
    static constexpr Section known[] = {{"SG_", &Parser::signal},
                                        {"BO_", &Parser::message},
                                        {"VAL_", &Parser::values},
                                        {"CM_", &Parser::comment},
                                        {"BA_", &Parser::attribute},
                                        {"VERSION", &Parser::version},
                                        {"NS_", &Parser::new_symbols},
                                        {"BS_", &Parser::bit_timing},
                                        {"BU_", &Parser::nodes},
                                        {"VAL_TABLE_", &Parser::value_table},
                                        {"SIG_VALTYPE_", &Parser::value_type},
                                        {"SG_MUL_VAL_", &Parser::multiplexing},
                                        {"BA_DEF_", &Parser::definition},
                                        {"BA_DEF_REL_", &Parser::definition},
                                        {"BA_DEF_DEF_", &Parser::attribute_default},
                                        {"BA_DEF_DEF_REL_", &Parser::attribute_default},
                                        {"BA_REL_", &Parser::relation}};
    const Token word = cursor_.peek_word();
    const auto* found = std::find_if(std::begin(known), std::end(known),
                                     [&](const Section& each) { return each.keyword == word.text; });
    if (found != std::end(known)) {
      cursor_.take_word();
      if (found->keyword != "SG_") in_message_ = found->keyword == "BO_";
      (this->*found->parse)();
      return true;
    }
    if (is_section(word.text) || looks_like_section(word.text)) {
      in_message_ = false;
      if (!is_section(word.text)) note(word, "section " + std::string(word.text) + " is unknown: skipped");
      cursor_.take_word();
      if (!cursor_.take_until_semicolon()) need_semicolon();
      return true;
    }
    return stray();
  }

  /// Skips an extra ';' and a comment of a programmer; the format has no such comments.
  bool stray() {
    const Token here{{cursor_.place(), 1}};
    if (cursor_.take(';')) {
      note(here, "an extra ';': skipped");
      return true;
    }
    if (cursor_.next() != '/') return false;
    const std::string_view line = cursor_.take_line();
    if (!line.starts_with("//")) throw ParseError{here.text.data(), "'/'", "a section of a DBC"};
    note(here, "a comment after '//' is not part of the format: skipped");
    return true;
  }

  void note(Token at, std::string what) { document_.warnings.add(at, std::move(what)); }

  template <class T>
  void add(std::vector<T>& list, T item, Token at, std::size_t most, const char* of) {
    if (list.size() == most) {
      throw ParseError{at.text.data(), std::to_string(most + 1) + ' ' + of,
                       "at most " + std::to_string(most)};
    }
    list.push_back(std::move(item));
  }

  /// A missing ';' before the next section, or at the end of the file, gives a warning.
  void need_semicolon() {
    if (cursor_.take(';')) return;
    if (cursor_.at_end()) {
      return note({cursor_.take_line()}, "the file ends before the last ';': it may be incomplete");
    }
    const Token next = cursor_.peek_word();
    if (!is_section(next.text) || !cursor_.at_line_start()) cursor_.refuse(semicolon);
    note(next, "found '" + std::string(next.text) + "' before " + semicolon);
  }

  // ---- network

  void version() {
    document_.version = cursor_.need_quoted("the version in quotes", longest_text);
    cursor_.take(';');
  }

  /// The names of sections, one or many on a line. A line that contains more is the next section.
  void new_symbols() {
    if (!cursor_.take(':')) cursor_.refuse(colon);
    while (!cursor_.at_end()) {
      const std::string_view word = cursor_.peek_word().text;
      if (word.empty() || word == "BS_" || word == "BU_" || word == "BO_" || word == "VERSION") return;
      Cursor ahead = cursor_;
      if (ahead.take_line().find_first_of("\":;=|") != std::string_view::npos) return;
      cursor_ = ahead;
    }
  }

  void bit_timing() {
    cursor_.need(':', colon);
    cursor_.take_any_of("0123456789:,.;");
  }

  void nodes() {
    cursor_.need(':', colon);
    while (true) {
      const Token word = cursor_.peek_word();
      if (word.text.empty() || is_section(word.text)) break;
      if (cursor_.at_line_start() && looks_like_section(word.text)) break;
      add(document_.nodes, cursor_.need_word("the name of a node"), word, most_nodes, "nodes");
      cursor_.take(',');
    }
    cursor_.take(';');
  }

  // ---- messages

  void message() {
    MessageBlock block;
    block.id = cursor_.need_number(message_id);
    block.name = cursor_.need_word("the name of a message");
    const std::string of = " of message " + std::string(block.name.text);
    cursor_.need(':', "':' after the name" + of);
    block.length = cursor_.need_number("the length" + of + " in bytes");
    if (cursor_.next_is_on_this_line()) {
      block.sender = cursor_.need_word("the sender" + of);
    } else {
      note(block.name, "message " + std::string(block.name.text) + " names no sender");
    }
    cursor_.take(';');
    const Token at = block.id;
    add(document_.messages, std::move(block), at, most_messages, "messages");
  }

  void signal() {
    SignalLine line;
    line.name = cursor_.need_word(signal_name);
    if (!in_message_) {
      throw ParseError{line.name.text.data(), "signal " + std::string(line.name.text),
                       "a message (BO_) before it"};
    }
    const std::string of = " of signal " + std::string(line.name.text);
    if (const auto word = cursor_.take_word()) line.multiplexing = *word;
    cursor_.need(':', "':' after the name" + of);
    line.start_bit = cursor_.need_number("the start bit" + of);
    cursor_.need('|', "'|' in the bit position" + of);
    line.length = cursor_.need_number("the length" + of + " in bits");
    cursor_.need('@', "'@' before the byte order" + of);
    line.byte_order = one_of("01", "0 (big-endian) or 1 (little-endian) as the byte order" + of);
    line.sign = one_of("+-", "'+' (unsigned) or '-' (signed) as the value type" + of);
    cursor_.need('(', "'(' before the scale" + of);
    line.scale = cursor_.need_number("the scale" + of + ", a number");
    cursor_.need(',', "',' between scale and offset" + of);
    line.offset = cursor_.need_number("the offset" + of + ", a number");
    cursor_.need(')', "')' after the offset" + of);
    cursor_.need('[', "'[' before the range" + of);
    line.minimum = cursor_.need_number("the minimum" + of + ", a number");
    cursor_.need('|', "'|' in the range" + of);
    line.maximum = cursor_.need_number("the maximum" + of + ", a number");
    cursor_.need(']', "']' after the range" + of);
    line.unit = cursor_.need_quoted("the unit" + of + " in quotes", longest_name);
    if (line.unit.text.find_first_of("\r\n") != std::string_view::npos)
      throw ParseError{line.unit.text.data() - 1, "a text over several lines",
                       "the unit" + of + " in one line"};
    receivers(line.receivers);
    const Token at = line.name;
    add(document_.messages.back().signals, std::move(line), at, most_signals, "signals of a message");
  }

  Token one_of(std::string_view marks, const std::string& words) {
    const Token mark{{cursor_.place(), 1}};
    if (marks.find(cursor_.next()) == std::string_view::npos || cursor_.at_end()) cursor_.refuse(words);
    cursor_.take(mark.text.front());
    return mark;
  }

  /// The receivers on the signal's line and, after a comma, on the next line.
  void receivers(std::vector<Token>& names) {
    bool more = false;
    while (more || cursor_.next_is_on_this_line()) {
      if (is_section(cursor_.peek_word().text)) break;
      const Token name = cursor_.peek_word();
      if (name.text.empty()) break;
      add(names, cursor_.need_word("a receiver"), name, most_items, "receivers of a signal");
      more = cursor_.take(',');
    }
    cursor_.take(';');
  }

  // ---- comments, values and types of messages and signals

  Subject subject() {
    Subject result;
    if (cursor_.take_keyword("BU_")) {
      result.kind = Subject::Kind::node;
      result.name = cursor_.need_word("the name of a node");
    } else if (cursor_.take_keyword("BO_")) {
      result.kind = Subject::Kind::message;
      result.id = cursor_.need_number(message_id);
    } else if (cursor_.take_keyword("SG_")) {
      result.kind = Subject::Kind::signal;
      result.id = cursor_.need_number(message_id);
      result.name = cursor_.need_word(signal_name);
    } else if (cursor_.take_keyword("EV_")) {
      result.kind = Subject::Kind::environment;
      result.name = cursor_.need_word("the name of an environment variable");
    }
    return result;
  }

  void comment() {
    const char next = cursor_.next();
    Comment comment{subject(), {}};
    if (comment.subject.kind == Subject::Kind::network && next != '"')
      cursor_.refuse("BO_, SG_, BU_, EV_ or a comment in quotes");
    comment.text = cursor_.need_quoted(quoted_text, longest_text);
    need_semicolon();
    document_.comments.push_back(comment);
  }

  std::vector<ValueName> value_names() {
    std::vector<ValueName> names;
    while (const auto raw = cursor_.take_number()) {
      const Token name = cursor_.need_quoted(quoted_text, longest_name);
      add(names, {*raw, name}, *raw, most_items, "names of values");
      cursor_.take(',');
    }
    return names;
  }

  void value_table() {
    ValueTable table;
    table.name = cursor_.need_word("the name of a value table");
    table.names = value_names();
    need_semicolon();
    document_.value_tables.push_back(std::move(table));
  }

  /// The values of a signal or of an environment variable, which has no message.
  void values() {
    SignalValues values;
    const Token first = cursor_.need_word("the identifier of a message");
    if (first.text.find_first_not_of("0123456789") != std::string_view::npos &&
        !first.text.starts_with("0x")) {
      value_names();
      need_semicolon();
      return;
    }
    values.id = first;
    values.signal = cursor_.need_word(signal_name);
    values.names = value_names();
    if (const auto word = cursor_.next() == ';' ? std::nullopt : table_name()) values.table = *word;
    need_semicolon();
    document_.values.push_back(std::move(values));
  }

  std::optional<Token> table_name() {
    if (is_section(cursor_.peek_word().text)) return std::nullopt;
    return cursor_.take_word();
  }

  void value_type() {
    SignalValueType line;
    line.id = cursor_.need_number(message_id);
    line.signal = cursor_.need_word(signal_name);
    cursor_.take(':');
    line.type = cursor_.need_number("the value type of signal " + std::string(line.signal.text) + ", 0 to 3");
    need_semicolon();
    document_.value_types.push_back(line);
  }

  void multiplexing() {
    SignalMultiplexing line;
    line.id = cursor_.need_number(message_id);
    line.signal = cursor_.need_word(signal_name);
    line.multiplexer = cursor_.need_word("the name of the multiplexer");
    do {
      MultiplexedRange range;
      range.low = cursor_.need_number("a multiplexer value");
      cursor_.need('-', "'-' between two multiplexer values");
      range.high = cursor_.need_number("a multiplexer value");
      add(line.ranges, range, range.low, most_items, "ranges of a multiplexer");
    } while (cursor_.take(',') || cursor_.next_is_digit());
    need_semicolon();
    document_.multiplexing.push_back(std::move(line));
  }

  // ---- attributes

  void definition() {
    AttributeDefinition definition;
    if (const auto object = cursor_.take_word()) definition.object = *object;
    definition.name = cursor_.need_quoted("the name of an attribute in quotes", longest_name);
    definition.type = cursor_.need_word("INT, HEX, FLOAT, STRING or ENUM");
    while (cursor_.next() != ';' && !cursor_.at_end()) {
      if (const auto item = item_of_definition()) {
        add(definition.items, *item, *item, most_items, "items of an attribute");
        cursor_.take(',');
      } else {
        break;
      }
    }
    need_semicolon();
    document_.definitions.push_back(std::move(definition));
  }

  std::optional<Token> item_of_definition() {
    if (cursor_.next() == '"') return cursor_.need_quoted(quoted_text, longest_name);
    return cursor_.take_number();
  }

  Value value() {
    if (cursor_.next() == '"') return {cursor_.need_quoted(quoted_text, longest_text), true};
    if (const auto number = cursor_.take_number()) return {*number, false};
    return {cursor_.need_word("a number or a text in quotes"), true};
  }

  void attribute_default() {
    AttributeDefault line;
    line.name = cursor_.need_quoted("the name of an attribute in quotes", longest_name);
    line.value = value();
    need_semicolon();
    document_.defaults.push_back(line);
  }

  void attribute() {
    AttributeLine line;
    line.name = cursor_.need_quoted("the name of an attribute in quotes", longest_name);
    line.subject = subject();
    line.value = value();
    need_semicolon();
    document_.attributes.push_back(line);
  }

  void relation() {
    RelationLine line;
    line.name = cursor_.need_quoted("the name of an attribute in quotes", longest_name);
    const Token kind = cursor_.need_word("BU_SG_REL_, BU_BO_REL_ or BU_EV_REL_");
    line.node = cursor_.need_word("the name of a node");
    if (kind.text == "BU_SG_REL_") {
      line.subject = subject();
    } else if (kind.text == "BU_BO_REL_") {
      line.subject.kind = Subject::Kind::message;
      line.subject.id = cursor_.need_number(message_id);
    } else {
      line.subject.kind = Subject::Kind::environment;
      line.subject.name = cursor_.need_word("the name of an environment variable");
    }
    line.value = value();
    need_semicolon();
    document_.relations.push_back(line);
  }

  Cursor cursor_;
  Document document_;
  bool in_message_ = false;  ///< a signal line may follow
};

}  // namespace

Document parse_document(std::string_view text) { return Parser(text).run(); }

}  // namespace hystcan::can::dbc
