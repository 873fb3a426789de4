// From the syntax of a DBC to what it means.
#pragma once

#include <string>
#include <vector>

#include "can/dbc.h"
#include "can/dbc_grammar.h"

namespace hystcan::can::dbc {

/// A message with its signals; comments, names of values,
/// attributes and multiplexing come later. Throws Mistake; what is odd goes to `oddities`.
Message read_message(const MessageBlock& block, std::vector<Oddity>& oddities);

/// The document's meaning; `document.oddities` grows by what is odd in it. Throws Mistake.
Database read_document(Document& document);

/// Definitions, values given and defaults of attributes; the fields that follow from them.
class AttributeReader {
 public:
  AttributeReader(Database& database, std::vector<Oddity>& oddities)
      : database_(database), oddities_(oddities) {}

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
  std::vector<Oddity>& oddities_;
};

std::uint64_t natural(Token token, std::uint64_t minimum, std::uint64_t maximum, const std::string& what);
std::string cited(Token token);

}  // namespace hystcan::can::dbc
