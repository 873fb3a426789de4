#include <array>
#include <utility>

#include "can/dbc/reader.h"
#include "can/dbc/text.h"

namespace hystcan::can::dbc {
namespace {

using Type = can::AttributeDefinition::Type;

std::optional<Type> type_named(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, Type>, 5> types = {{{"INT", Type::integer},
                                                                       {"HEX", Type::hexadecimal},
                                                                       {"FLOAT", Type::real},
                                                                       {"STRING", Type::text},
                                                                       {"ENUM", Type::enumeration}}};
  for (const auto& [name, type] : types) {
    if (name == word) return type;
  }
  return std::nullopt;
}

AttributeValue number_or_text(std::string_view text) {
  if (const auto whole = to_integer(text)) return *whole;
  if (const auto real = to_real(text)) return *real;
  return unescaped(text);
}

std::optional<double> number_in(const AttributeValue* value) {
  if (value == nullptr) return std::nullopt;
  if (const auto* whole = std::get_if<std::int64_t>(value)) return static_cast<double>(*whole);
  if (const auto* real = std::get_if<double>(value)) return *real;
  return std::nullopt;
}

/// VFrameFormat is an ENUM with names, or an INT with the numbers of Vector.
std::optional<bool> is_fd_format(const AttributeValue* value) {
  if (value == nullptr) return std::nullopt;
  if (const auto* name = std::get_if<std::string>(value)) return name->ends_with("FD");
  const auto number = number_in(value);
  return number == 14.0 || number == 15.0;  // StandardCAN_FD, ExtendedCAN_FD
}

}  // namespace

void AttributeReader::define(const AttributeDefinition& line) {
  can::AttributeDefinition definition;
  definition.object = line.object.text;
  const auto type = type_named(line.type.text);
  if (!type) {
    throw ParseError{line.type.text.data(), cited(line.type), "INT, HEX, FLOAT, STRING or ENUM"};
  }
  definition.type = *type;
  if (*type == Type::enumeration) {
    definition.items.reserve(line.items.size());
    for (const Token& item : line.items) definition.items.push_back(unescaped(item.text));
  }
  database_.attribute_definitions[unescaped(line.name.text)] = std::move(definition);
}

void AttributeReader::set_default(const AttributeDefault& line) {
  const auto found = database_.attribute_definitions.find(unescaped(line.name.text));
  if (found == database_.attribute_definitions.end()) {
    warnings_.add(line.name, "a default for attribute " + cited(line.name) + ", which is not defined");
    return;
  }
  found->second.default_value = value_of(line.name, line.value);
}

AttributeValue AttributeReader::value_of(Token name, const Value& value) {
  const std::string_view text = value.token.text;
  const auto found = database_.attribute_definitions.find(unescaped(name.text));
  if (found == database_.attribute_definitions.end()) {
    warnings_.add(name, "attribute " + cited(name) + " is not defined");
    return value.quoted ? AttributeValue(unescaped(text)) : number_or_text(text);
  }
  const can::AttributeDefinition& definition = found->second;
  switch (definition.type) {
    case Type::text:
      return unescaped(text);
    case Type::enumeration: {
      const auto number = value.quoted ? std::nullopt : to_natural(text);
      if (number && *number < definition.items.size()) {
        copies_.take(value.token, definition.items[*number].size());
        return definition.items[*number];
      }
      if (number)
        warnings_.add(value.token, "attribute " + cited(name) + " has no item " + std::string(text));
      return number ? number_or_text(text) : AttributeValue(unescaped(text));
    }
    case Type::real:
      if (const auto real = to_real(text)) return *real;
      break;
    case Type::integer:
    case Type::hexadecimal:
      break;
  }
  return number_or_text(text);
}

void AttributeReader::derive() {
  for (Message& message : database_.messages) derive(message);
}

void AttributeReader::derive(Message& message) const {
  const auto of_message = [&](std::string_view name) {
    return attribute(database_, message.attributes, name);
  };
  const auto cycle_time_ms = number_in(of_message("GenMsgCycleTime"));
  if (cycle_time_ms && *cycle_time_ms > 0.0) message.cycle_time_ms = cycle_time_ms;
  if (const auto fd = is_fd_format(of_message("VFrameFormat"))) message.fd = *fd;
  for (Signal& signal : message.signals)
    signal.start_value = number_in(attribute(database_, signal.attributes, "GenSigStartValue"));
}

}  // namespace hystcan::can::dbc
