// Attributes: their definitions, defaults and values; the long names and the fields that follow from them.
#include <array>
#include <set>

#include "can/dbc/reader.h"
#include "can/dbc/text.h"

namespace hystcan::can::dbc {
namespace {

using Type = AttributeDefinition::Type;

constexpr const char* attribute_name = "the name of an attribute in quotes";

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

void Reader::definition() {
  AttributeDefinition definition;
  if (const auto object = cursor_.take_word()) definition.object = *object;
  const std::string_view name = cursor_.need_quoted(attribute_name, longest_name);
  const std::string_view type = cursor_.need_word("INT, HEX, FLOAT, STRING or ENUM");
  const auto known_type = type_named(type);
  if (!known_type) throw ParseError{type.data(), cited(type), "INT, HEX, FLOAT, STRING or ENUM"};
  definition.type = *known_type;
  while (cursor_.next() != ';' && !cursor_.at_end()) {  // the names of an ENUM; the range of a number
    const auto item =
        cursor_.next() == '"' ? cursor_.need_quoted(quoted_text, longest_name) : cursor_.take_number();
    if (!item) break;
    need_room(definition.items.size(), most_items, *item, "items of an attribute");
    definition.items.push_back(unescaped(*item));
    cursor_.take(',');
  }
  need_semicolon();
  if (definition.type != Type::enumeration) definition.items.clear();
  database_.attribute_definitions[unescaped(name)] = std::move(definition);
}

Reader::Value Reader::value() {
  if (cursor_.next() == '"') return {cursor_.need_quoted(quoted_text, longest_text), true};
  if (const auto number = cursor_.take_number()) return {*number, false};
  return {cursor_.need_word("a number or a text in quotes"), true};
}

void Reader::attribute_default() {
  const std::string_view name = cursor_.need_quoted(attribute_name, longest_name);
  const Value given = value();
  need_semicolon();
  details_.emplace_back([this, name, given] {
    const auto found = database_.attribute_definitions.find(unescaped(name));
    if (found == database_.attribute_definitions.end())
      note(name, "a default for attribute " + cited(name) + ", which is not defined");
    else
      found->second.default_value = value_of(name, given);
  });
}

/// Names of more than 32 characters stand shortened in the file, and whole in an attribute.
void Reader::attribute() {
  const std::string_view name = cursor_.need_quoted(attribute_name, longest_name);
  const Subject of = subject();
  const Value given = value();
  need_semicolon();
  details_.emplace_back([this, name, of, given] {
    const std::string key = unescaped(name);
    const AttributeValue attribute = value_of(name, given);
    const auto* text = std::get_if<std::string>(&attribute);
    for_objects(of, key.size() + (text != nullptr ? text->size() : 0),
                [&](auto& object) { object.attributes.insert_or_assign(key, attribute); });
  });
  const bool is_long_name = (of.kind == "BO_" && name == "SystemMessageLongSymbol") ||
                            (of.kind == "SG_" && name == "SystemSignalLongSymbol") ||
                            (of.kind == "BU_" && name == "SystemNodeLongSymbol");
  if (is_long_name && !given.text.empty())
    long_names_.emplace_back([this, of, given] { set_long_name(of, given.text); });
}

void Reader::set_long_name(const Subject& subject, std::string_view name) {
  if (name.size() > longest_name || !Cursor::is_word(name))
    return note(name, cited(name) + " is not a name: the name in the file stays");
  const std::string long_name = to_utf8(name);
  for_objects(subject, long_name.size(), [&](auto& object) {
    if constexpr (requires { object.short_name; }) {
      if (object.short_name.empty()) object.short_name = object.name;
      object.name = long_name;
    }
  });
}

void Reader::relation() {
  const std::string_view name = cursor_.need_quoted(attribute_name, longest_name);
  const std::string_view kind = cursor_.need_word("BU_SG_REL_, BU_BO_REL_ or BU_EV_REL_");
  const std::string_view node = cursor_.need_word("the name of a node");
  Subject with;
  if (kind == "BU_SG_REL_")
    with = subject();
  else if (kind == "BU_BO_REL_")
    with.id = cursor_.need_number(message_id);
  else
    with.name = cursor_.need_word("the name of an environment variable");
  const Value given = value();
  need_semicolon();
  relations_.emplace_back([this, name, node, with, given] { add_relation(name, node, with, given); });
}

/// The names of the objects are the long ones.
void Reader::add_relation(std::string_view name, std::string_view node, const Subject& subject,
                          const Value& value) {
  RelationAttribute relation{
      unescaped(name), to_utf8(node), {}, to_utf8(subject.name), value_of(name, value)};
  const auto found = nodes_.find(node);
  if (found != nodes_.end()) relation.node = database_.nodes[found->second].name;
  count_copies(node, relation.node.size());
  if (!subject.id.empty()) {
    for_messages(subject.id, 0, [&](std::size_t index) {
      const Message& message = database_.messages[index];
      count_copies(subject.id, message.name.size());
      relation.message = message.name;
      const auto signal = texts_[index].signal_by_name.find(subject.name);
      if (signal == texts_[index].signal_by_name.end()) return;
      relation.object = message.signals[signal->second].name;
      count_copies(subject.name, relation.object.size());
    });
  }
  database_.relation_attributes.push_back(std::move(relation));
}

AttributeValue Reader::value_of(std::string_view name, const Value& value) {
  const auto found = database_.attribute_definitions.find(unescaped(name));
  if (found == database_.attribute_definitions.end()) {
    note(name, "attribute " + cited(name) + " is not defined");
    return value.quoted ? AttributeValue(unescaped(value.text)) : number_or_text(value.text);
  }
  const AttributeDefinition& definition = found->second;
  switch (definition.type) {
    case Type::text:
      return unescaped(value.text);
    case Type::enumeration: {
      const auto number = value.quoted ? std::nullopt : to_natural(value.text);
      if (!number) return unescaped(value.text);
      if (*number < definition.items.size()) {
        count_copies(value.text, definition.items[*number].size());
        return definition.items[*number];
      }
      note(value.text, "attribute " + cited(name) + " has no item " + std::string(value.text));
      break;
    }
    case Type::real:
      if (const auto real = to_real(value.text)) return *real;
      break;
    case Type::integer:
    case Type::hexadecimal:
      break;
  }
  return number_or_text(value.text);
}

/// Senders and receivers are names of nodes.
void Reader::name_nodes() {
  std::map<std::string_view, const std::string*> names;
  for (const Node& node : database_.nodes) {
    if (!node.short_name.empty()) names.emplace(node.short_name, &node.name);
  }
  if (names.empty()) return;
  const auto replace = [&](std::string& name, std::string_view at) {
    const auto found = names.find(name);
    if (found == names.end()) return;
    count_copies(at, found->second->size());
    name = *found->second;
  };
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    Message& message = database_.messages[i];
    replace(message.sender, texts_[i].name);
    for (Signal& signal : message.signals) {
      for (std::string& receiver : signal.receivers) replace(receiver, texts_[i].name);
    }
  }
}

void Reader::note_repeated_long_names() {
  std::set<std::string_view> messages;
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    const Message& message = database_.messages[i];
    if (!messages.insert(message.name).second && !message.short_name.empty()) {
      note(texts_[i].name, "message " + message.name + " occurs a second time: its name finds the first");
    }
    std::set<std::string_view> signals;
    for (std::size_t k = 0; k < message.signals.size(); ++k) {
      const Signal& signal = message.signals[k];
      const bool is_new = signals.insert(signal.name).second;
      if (is_new || signal.short_name.empty() || signal.multiplexing.present_at) continue;
      note(texts_[i].signals[k],
           "signal " + signal.name + " occurs a second time in message " + message.name + ": both are kept");
    }
  }
}

/// Sets the fields that follow from attributes.
void Reader::derive(Message& message) const {
  const auto of_message = [&](std::string_view name) {
    return can::attribute(database_, message.attributes, name);
  };
  const auto cycle_time_ms = number_in(of_message("GenMsgCycleTime"));
  if (cycle_time_ms && *cycle_time_ms > 0.0) message.cycle_time_ms = cycle_time_ms;
  if (const auto fd = is_fd_format(of_message("VFrameFormat"))) message.fd = *fd;
  for (Signal& signal : message.signals)
    signal.start_value = number_in(can::attribute(database_, signal.attributes, "GenSigStartValue"));
}

}  // namespace hystcan::can::dbc
