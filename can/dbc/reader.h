// Interprets the syntax of a DBC and makes the database.
#pragma once

#include <string>
#include <vector>

#include "can/dbc/database.h"
#include "can/dbc/grammar.h"

namespace hystcan::can::dbc {

/// Counts what is copied to several objects, so that a small file cannot make a large database.
class Copies {
 public:
  /// Throws ParseError if all copies together are too large.
  void take(Token at, std::size_t bytes) {
    taken_ += bytes;
    if (taken_ <= largest_copies) return;
    throw ParseError{at.text.data(), "a section that applies to too many objects",
                     "at most " + std::to_string(largest_copies) + " bytes of copies in the file"};
  }

 private:
  std::size_t taken_ = 0;
};

/// A message with its signals, but without comments, names of values, attributes and extended multiplexing.
/// Throws ParseError; irregularities go to `warnings`.
Message read_message(const MessageBlock& block, Warnings& warnings);

/// The database of the document. Adds irregularities to `document.warnings`. Throws ParseError.
Database read_document(Document& document);

/// Gives senders and receivers the long names of their nodes, and notes long names that occur twice. `blocks`
/// is the text of each message of the database.
void finish_long_names(Database& database, const std::vector<const MessageBlock*>& blocks, Warnings& warnings,
                       Copies& copies);

/// Reads definitions, values and defaults of attributes, and sets the fields that follow from them.
class AttributeReader {
 public:
  AttributeReader(Database& database, Warnings& warnings, Copies& copies)
      : database_(database), warnings_(warnings), copies_(copies) {}

  void define(const AttributeDefinition& definition);
  void set_default(const AttributeDefault& line);
  /// The value by the attribute's definition, which converts the number of an ENUM's item to its name.
  AttributeValue value_of(Token name, const Value& value);
  /// Sets cycle times, CAN FD and start values.
  void derive();

 private:
  void derive(Message& message) const;

  Database& database_;
  Warnings& warnings_;
  Copies& copies_;
};

std::uint64_t natural(Token token, std::uint64_t minimum, std::uint64_t maximum, const std::string& what);
/// The token in quotes; a long one is cut.
std::string cited(Token token);

}  // namespace hystcan::can::dbc
