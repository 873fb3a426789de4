// Interprets the syntax of a DBC and makes the database.
#pragma once

#include <string>
#include <vector>

#include "can/dbc/database.h"
#include "can/dbc/grammar.h"

namespace hystcan::can::dbc {

/// A message with its signals, but without comments, names of values, attributes and extended multiplexing.
/// Throws ParseError; irregularities go to `warnings`.
Message read_message(const MessageBlock& block, std::vector<ParseWarning>& warnings);

/// The database of the document. Adds irregularities to `document.warnings`. Throws ParseError.
Database read_document(Document& document);

/// Reads definitions, values and defaults of attributes, and sets the fields that follow from them.
class AttributeReader {
 public:
  AttributeReader(Database& database, std::vector<ParseWarning>& warnings)
      : database_(database), warnings_(warnings) {}

  void define(const AttributeDefinition& definition);
  void set_default(const AttributeDefault& line);
  /// The value by the attribute's definition, which converts the number of an ENUM's item to its name.
  AttributeValue value_of(Token name, const Value& value);
  /// Sets cycle times, CAN FD and start values.
  void derive();

 private:
  void derive(Message& message) const;
  void note(Token at, std::string what);

  Database& database_;
  std::vector<ParseWarning>& warnings_;
};

std::uint64_t natural(Token token, std::uint64_t minimum, std::uint64_t maximum, const std::string& what);
std::string cited(Token token);

}  // namespace hystcan::can::dbc
