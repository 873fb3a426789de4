// The syntax of a DBC, as tokens of the text itself: what they mean, and whether they may, is for
// dbc_reader.cpp to say.
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
  Token sender;  ///< may be empty
  std::vector<SignalLine> signals;
};

/// What a comment or an attribute is about.
struct Subject {
  enum class Kind { network, node, message, signal, environment };
  Kind kind = Kind::network;
  Token name;  ///< of node, signal or environment variable
  Token id;    ///< of the message
};

struct Comment {
  Subject subject;
  Token text;
};

struct ValueName {
  Token raw;
  Token name;
};

struct ValueTable {
  Token name;
  std::vector<ValueName> names;
};

struct SignalValues {
  Token id;
  Token signal;
  Token table;  ///< in the place of names
  std::vector<ValueName> names;
};

struct SignalValueType {
  Token id;
  Token signal;
  Token type;
};

struct MultiplexedRange {
  Token low;
  Token high;
};

struct SignalMultiplexing {
  Token id;
  Token signal;
  Token multiplexer;
  std::vector<MultiplexedRange> ranges;
};

/// BA_DEF_ and BA_DEF_REL_.
struct AttributeDefinition {
  Token object;  ///< "BU_", "BO_", "SG_", "EV_", "BU_SG_REL_" and the like; empty: the network
  Token name;
  Token type;
  std::vector<Token> items;  ///< the names of an ENUM; the range of a number
};

/// A number or a text in quotes.
struct Value {
  Token token;
  bool quoted = false;
};

struct AttributeDefault {
  Token name;
  Value value;
};

struct AttributeLine {
  Token name;
  Subject subject;
  Value value;
};

/// BA_REL_: of a node and what it has to do with.
struct RelationLine {
  Token name;
  Token node;
  Subject subject;
  Value value;
};

/// Something odd that is read all the same.
struct ParseWarning {
  const char* where;
  std::string what;
};

struct Document {
  Token version;
  std::vector<Token> nodes;
  std::vector<MessageBlock> messages;
  std::vector<ValueTable> value_tables;
  std::vector<Comment> comments;
  std::vector<SignalValues> values;
  std::vector<SignalValueType> value_types;
  std::vector<SignalMultiplexing> multiplexing;
  std::vector<AttributeDefinition> definitions;
  std::vector<AttributeDefault> defaults;
  std::vector<AttributeLine> attributes;
  std::vector<RelationLine> relations;
  std::vector<ParseWarning> warnings;
};

/// Where the text goes wrong.
struct ParseError {
  const char* where;
  std::string found;
  std::string expected;
};

/// The document's tokens point into `text`. Throws ParseError.
Document parse_document(std::string_view text);

}  // namespace hystcan::can::dbc
