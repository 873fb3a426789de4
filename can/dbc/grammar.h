// The syntax of a DBC as tokens of its text. can/dbc/reader.cpp interprets and checks them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "can/dbc/limits.h"

namespace hystcan::can::dbc {

/// A view into the parsed text; a string is without its quotes.
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

/// The object of a comment or of an attribute.
struct Subject {
  enum class Kind { network, node, message, signal, environment };
  Kind kind = Kind::network;
  Token name;  ///< name of the node, the signal or the environment variable
  Token id;    ///< identifier of the message
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
  Token table;  ///< a value table instead of `names`
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

/// BA_REL_: an attribute of a node together with a subject.
struct RelationLine {
  Token name;
  Token node;
  Subject subject;
  Value value;
};

/// An irregularity that the reader accepts.
struct ParseWarning {
  const char* where;
  std::string what;
};

/// The first irregularities, and the number of the others.
struct Warnings {
  std::vector<ParseWarning> kept;
  std::size_t further = 0;

  void add(Token at, std::string what) {
    if (kept.size() < most_warnings)
      kept.push_back({at.text.data(), std::move(what)});
    else
      ++further;
  }
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
  Warnings warnings;
};

/// The first place where the text is not a DBC.
struct ParseError {
  const char* where;
  std::string found;
  std::string expected;
};

/// The document's tokens point into `text`. Throws ParseError.
Document parse_document(std::string_view text);

}  // namespace hystcan::can::dbc
