// The syntax of a DBC, as tokens of the text itself: what they mean, and whether they may, is for dbc.cpp to
// say.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hystcan::can::dbc {

/// A view into the parsed text; a string stands without its quotes.
struct Token {
  std::string_view text;
};

struct SignalLine {
  Token name;
  Token multiplexing;  ///< "", "M", "m3" or "m3M"
  Token start_bit;
  Token length;
  Token byte_order;  ///< "1" little-endian, "0" big-endian
  Token sign;        ///< "+" unsigned, "-" signed
  Token scale;
  Token offset;
  Token minimum;
  Token maximum;
  Token unit;
  std::vector<Token> receivers;
};

struct MessageBlock {
  Token id;
  Token name;
  Token length;
  Token sender;
  std::vector<SignalLine> signals;
};

struct MessageComment {
  Token id;
  Token text;
};

struct SignalComment {
  Token id;
  Token signal;
  Token text;
};

struct ValueName {
  Token raw;
  Token name;
};

struct SignalValues {
  Token id;
  Token signal;
  std::vector<ValueName> names;
};

struct SignalValueType {
  Token id;
  Token signal;
  Token type;
};

struct Document {
  Token version;
  std::vector<Token> nodes;
  std::vector<MessageBlock> messages;
  std::vector<MessageComment> message_comments;
  std::vector<SignalComment> signal_comments;
  std::vector<SignalValues> values;
  std::vector<SignalValueType> value_types;
};

/// Where the text goes wrong.
struct Mistake {
  const char* where;
  std::string found;
  std::string expected;
};

/// The document's tokens point into `text`. Throws Mistake.
Document parse_document(std::string_view text);

}  // namespace hystcan::can::dbc
