// From the syntax of a DBC to what it means.
#pragma once

#include <string>
#include <vector>

#include "can/dbc/database.h"
#include "can/dbc/grammar.h"

namespace hystcan::can::dbc {

/// A message with its signals; comments, names of values,
/// attributes and multiplexing come later. Throws ParseError; what is odd goes to `warnings`.
Message read_message(const MessageBlock& block, std::vector<ParseWarning>& warnings);

/// The document's meaning; `document.warnings` grows by what is odd in it. Throws ParseError.
Database read_document(Document& document);

/// Definitions, values given and defaults of attributes; the fields that follow from them.
class AttributeReader {
 public:
  AttributeReader(Database& database, std::vector<ParseWarning>& warnings)
      : database_(database), warnings_(warnings) {}

  void define(const AttributeDefinition& definition);
  void set_default(const AttributeDefault& line);
  /// By the attribute's definition, which turns the number of an ENUM's item into its name.
  AttributeValue value_of(Token name, const Value& value);
  /// Cycle times, CAN FD, start values.
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
