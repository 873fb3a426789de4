// The sections with details about messages and signals: comments, value names, types, extended multiplexing,
// attributes.
#include <algorithm>
#include <array>
#include <set>

#include "can/dbc/reader.h"
#include "can/dbc/text.h"

namespace hystcan::can::dbc {
namespace {

constexpr const char* attribute_name = "the name of an attribute in quotes";

std::size_t bytes_of(const std::map<std::int64_t, std::string>& names) {
  std::size_t bytes = 0;
  for (const auto& [raw, name] : names) bytes += bytes_of_an_entry + name.size();
  return bytes;
}

/// Returns ranges that contain the same values, ascend and do not overlap.
std::vector<Multiplexing::Range> disjoint(std::vector<Multiplexing::Range> ranges) {
  std::ranges::sort(ranges, std::less<>{}, &Multiplexing::Range::low);
  std::vector<Multiplexing::Range> result;
  for (const Multiplexing::Range& range : ranges) {
    if (result.empty() || range.low > result.back().high) {
      result.push_back(range);
    } else {
      result.back().high = std::max(result.back().high, range.high);
    }
  }
  return result;
}

}  // namespace

/// Returns true if this value of the attribute VFrameFormat means CAN FD. The value is the name of an ENUM
/// item, which ends in FD for CAN FD, or one of the numbers that Vector defines for CAN FD.
bool Reader::is_fd(const Value& format) {
  const auto number = format.is_text ? std::nullopt : to_real(format.token);
  if (!number) return format.token.ends_with("FD");
  return *number == 14.0 || *number == 15.0;  // StandardCAN_FD, ExtendedCAN_FD
}

/// Returns true if the value of the attribute CANFD_BRS is not 0. The attribute is an ENUM of "0" and "1", or
/// an INT.
bool Reader::switches(const Value& brs) { return to_real(brs.token) != 0.0; }

Reader::Subject Reader::subject() {
  const std::string_view kind = cursor_.peek_word();
  if (kind != "BU_" && kind != "BO_" && kind != "SG_" && kind != "EV_") return {};
  cursor_.take_word();
  Subject result{kind, {}, {}};
  if (kind == "BO_" || kind == "SG_") result.id = cursor_.need_number(message_id);
  if (kind == "SG_") result.name = cursor_.need_word(signal_name);
  if (kind == "BU_") result.name = cursor_.need_word("the name of a node");
  if (kind == "EV_") result.name = cursor_.need_word("the name of an environment variable");
  return result;
}

void Reader::comment() {
  const Subject of = subject();
  if (of.kind.empty() && cursor_.next() != '"') cursor_.refuse("BO_, SG_, BU_, EV_ or a comment in quotes");
  cursor_.need_quoted(quoted_text, longest_text);
  need_semicolon();
  details_.emplace_back([this, of] { for_objects(of, 0, [](const auto&) {}); });
}

/// Reads pairs of a raw value and its name. A raw value above the range of std::int64_t is stored as the
/// signed value with the same 64 bits.
Reader::Names Reader::value_names() {
  Names names;
  for (std::size_t count = 0; const auto raw = cursor_.take_number(); ++count) {
    const std::string_view name = cursor_.need_quoted(quoted_text, longest_name);
    need_room(count, most_items, *raw, "names of values");
    const auto natural_value = to_natural(*raw);
    const auto value = natural_value ? static_cast<std::int64_t>(*natural_value) : to_integer(*raw);
    if (value)
      names[*value] = unescaped(name);
    else
      note(*raw, cited(*raw) + " is not a raw value of at most 64 bits: the name of this value is ignored");
    cursor_.take(',');
  }
  return names;
}

void Reader::value_table() {
  const std::string_view name = cursor_.need_word("the name of a value table");
  Names& table = value_tables_[to_utf8(name)];
  for (const auto& [raw, value] : value_names()) table[raw] = value;
  need_semicolon();
}

/// Reads the value names of a signal (VAL_). Skips the value names of an environment variable, whose section
/// has a name instead of a message identifier.
void Reader::values() {
  const std::string_view id = cursor_.need_word(message_id);
  const bool is_variable =
      id.find_first_not_of("0123456789") != std::string_view::npos && !id.starts_with("0x");
  if (is_variable) {
    value_names();
    return need_semicolon();
  }
  const std::string_view signal = cursor_.need_word(signal_name);
  const Names names = value_names();
  std::string_view table;  // set if the section refers to a table instead of listing names
  if (cursor_.next() != ';' && !is_section(cursor_.peek_word())) table = cursor_.take_word().value_or("");
  need_semicolon();
  details_.emplace_back([this, id, signal, table, names] { set_values(id, signal, table, names); });
}

void Reader::set_values(std::string_view id, std::string_view signal, std::string_view table, Names names) {
  if (!table.empty()) {
    const auto found = value_tables_.find(to_utf8(table));
    if (found == value_tables_.end()) {
      note(table, "there is no value table " + std::string(table));
    } else {
      count_copies(table, bytes_of(found->second));
      names.insert(found->second.begin(), found->second.end());
    }
  }
  for_signals(id, signal, bytes_of(names), [&](Signal& each) {
    for (const auto& [raw, name] : names) each.values.insert_or_assign(raw, name);
  });
}

/// Reads the value type of a signal (SIG_VALTYPE_). The signal length decides between float and double,
/// because real files confuse the two types.
void Reader::value_type() {
  const std::string_view id = cursor_.need_number(message_id);
  const std::string_view signal = cursor_.need_word(signal_name);
  cursor_.take(':');
  const std::string_view token =
      cursor_.need_number("the value type of signal " + std::string(signal) + ", 0 to 3");
  need_semicolon();
  const std::uint64_t type = natural(token, 0, 3, "a value type");
  details_.emplace_back([this, id, signal, token, type] {
    for_signals(id, signal, 0, [&](Signal& each) {
      if (type != 1 && type != 2) return;
      const bool fits = each.length == 32 || each.length == 64;
      if (!fits || each.length != 32 * type)
        note(token, "signal " + each.name + " of " + std::to_string(each.length) +
                        " bits can't have value type " + std::to_string(type) +
                        (fits ? ": the type that fits the length is used" : ": the signal is not decoded"));
      each.value_type = !fits               ? ValueType::unreadable
                        : each.length == 32 ? ValueType::float32
                                            : ValueType::float64;
    });
  });
}

void Reader::multiplexing() {
  const std::string_view id = cursor_.need_number(message_id);
  const std::string_view switched = cursor_.need_word(signal_name);
  const std::string_view by = cursor_.need_word("the name of the multiplexer");
  Ranges ranges;
  std::size_t count = 0;
  do {
    const std::string_view low = cursor_.need_number("a multiplexer value");
    cursor_.need('-', "'-' between two multiplexer values");
    const std::string_view high = cursor_.need_number("a multiplexer value");
    need_room(count++, most_items, low, "ranges of a multiplexer");
    const Multiplexing::Range range{natural(low, 0, ~std::uint64_t{0}, "a multiplexer value"),
                                    natural(high, 0, ~std::uint64_t{0}, "a multiplexer value")};
    if (range.low <= range.high)
      ranges.push_back(range);
    else
      note(low, "the range from " + std::string(low) + " to " + std::string(high) +
                    " has no value: the range is ignored");
  } while (cursor_.take(',') || cursor_.next_is_digit());
  need_semicolon();
  details_.emplace_back(
      [this, id, switched, by, ranges = disjoint(ranges)] { set_multiplexing(id, switched, by, ranges); });
}

void Reader::set_multiplexing(std::string_view id, std::string_view switched, std::string_view by,
                              const Ranges& ranges) {
  for_messages(id, bytes_of_an_entry * ranges.size(), [&](std::size_t index) {
    Message& message = database_.messages[index];
    const auto& signals = texts_[index].signal_by_name;
    const auto found_switch = signals.find(by);  // the first signal of this name
    const auto [first, last] = signals.equal_range(switched);
    if (first == last || found_switch == signals.end()) {
      const std::string_view missing = first == last ? switched : by;
      return note(missing, "message " + message.name + " has no signal " + std::string(missing));
    }
    const bool alone = std::next(first) == last;
    for (auto each = first; each != last; ++each) {
      if (each != first) count_copies(switched, bytes_of_an_entry);
      Multiplexing& multiplexing = message.signals[each->second].multiplexing;
      multiplexing.switched_by = found_switch->second;
      if (alone) multiplexing.ranges = ranges;
    }
    message.signals[found_switch->second].multiplexing.is_switch = true;
  });
}

void Reader::definition() {
  cursor_.take_word();  // skips the kind of object, such as BO_
  const std::string name = unescaped(cursor_.need_quoted(attribute_name, longest_name));
  constexpr const char* any_type = "INT, HEX, FLOAT, STRING or ENUM";
  constexpr std::array<std::string_view, 5> types = {"INT", "HEX", "FLOAT", "STRING", "ENUM"};
  Attribute attribute{cursor_.need_word(any_type), {}, {}};
  if (std::ranges::find(types, attribute.type) == types.end())
    throw ParseError{attribute.type.data(), cited(attribute.type), any_type};
  while (cursor_.next() != ';' && !cursor_.at_end()) {  // names of an ENUM, or the limits of a number
    const auto item =
        cursor_.next() == '"' ? cursor_.need_quoted(quoted_text, longest_name) : cursor_.take_number();
    if (!item) break;
    need_room(attribute.items.size(), most_items, *item, "items of an attribute");
    attribute.items.push_back(*item);
    cursor_.take(',');
  }
  need_semicolon();
  attributes_[name] = std::move(attribute);
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
    const auto found = attributes_.find(unescaped(name));
    if (found == attributes_.end())
      note(name, "a default for attribute " + cited(name) + ", which is not defined");
    else
      found->second.default_value = known_value(name, given);
  });
}

/// Reads the value of an attribute (BA_) of an object. If the name of a node, message or signal has more than
/// 32 characters, a DBC contains a short name instead. An attribute of this object, for example
/// SystemSignalLongSymbol of a signal, then contains the long name.
void Reader::attribute() {
  const std::string_view name = cursor_.need_quoted(attribute_name, longest_name);
  const Subject of = subject();
  const Value given = value();
  need_semicolon();
  details_.emplace_back([this, name, of, given] {
    const Value known = known_value(name, given);
    const bool is_format = name == frame_format;
    if (of.kind != "BO_" || (!is_format && name != bit_rate_switch))
      return for_objects(of, 0, [](const auto&) {});
    for_messages(of.id, 0, [&](std::size_t index) {
      (is_format ? texts_[index].fd : texts_[index].switches) = is_format ? is_fd(known) : switches(known);
    });
  });
  const bool is_long_name = (of.kind == "BO_" && name == "SystemMessageLongSymbol") ||
                            (of.kind == "SG_" && name == "SystemSignalLongSymbol") ||
                            (of.kind == "BU_" && name == "SystemNodeLongSymbol");
  if (is_long_name && !given.token.empty())
    long_names_.emplace_back([this, of, given] { set_long_name(of, given.token); });
}

void Reader::set_long_name(const Subject& subject, std::string_view name) {
  if (name.size() > longest_name || !Cursor::is_word(name))
    return note(name, cited(name) + " is not a valid long name: the short name is kept");
  const std::string long_name = to_utf8(name);
  for_objects(subject, long_name.size(), [&](auto& object) {
    if constexpr (requires { object.short_name; }) {
      if (object.short_name.empty()) object.short_name = object.name;
      object.name = long_name;
    } else {
      object = long_name;
    }
  });
}

/// Reads the value of an attribute that belongs to a pair of objects (BA_REL_). The first object is a node.
/// The second object is a message, a signal or an environment variable. The value is checked but not stored.
void Reader::relation() {
  const std::string_view name = cursor_.need_quoted(attribute_name, longest_name);
  const std::string_view kind = cursor_.need_word("BU_SG_REL_, BU_BO_REL_ or BU_EV_REL_");
  cursor_.need_word("the name of a node");
  std::string_view id;
  if (kind == "BU_SG_REL_")
    id = subject().id;
  else if (kind == "BU_BO_REL_")
    id = cursor_.need_number(message_id);
  else
    cursor_.need_word("the name of an environment variable");
  const Value given = value();
  need_semicolon();
  details_.emplace_back([this, name, id, given] {
    known_value(name, given);
    if (!id.empty()) for_messages(id, 0, [](std::size_t) {});
  });
}

/// Interprets the value of an attribute as a text or a number, according to the definition of the attribute.
/// Replaces the number of an ENUM item by the name of the item.
Reader::Value Reader::known_value(std::string_view name, const Value& value) {
  const auto found = attributes_.find(unescaped(name));
  if (found == attributes_.end()) {
    note(name, "attribute " + cited(name) + " is not defined");
    return value;
  }
  const auto& [type, items, default_value] = found->second;
  if (type == "STRING") return {value.token, true};
  if (type != "ENUM") return {value.token, false};
  const auto number = value.is_text ? std::nullopt : to_natural(value.token);
  if (!number) return {value.token, true};
  if (*number < items.size()) return {items[*number], true};
  note(value.token, "attribute " + cited(name) + " has no item " + std::string(value.token));
  return value;
}

/// Replaces the sender of each message by the long name of this node, if the node has a long name.
void Reader::name_senders() {
  std::map<std::string, const std::string*> names;
  for (const auto& [name, long_name] : nodes_)
    if (!long_name.empty()) names.emplace(to_utf8(name), &long_name);
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    std::string& sender = database_.messages[i].sender;
    const auto found = names.find(sender);
    if (found == names.end()) continue;
    count_copies(texts_[i].name, found->second->size());
    sender = *found->second;
  }
}

void Reader::note_repeated_long_names() {
  std::set<std::string_view> messages;
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    const Message& message = database_.messages[i];
    if (!messages.insert(message.name).second && !message.short_name.empty())
      note(texts_[i].name,
           "message " + message.name + " occurs a second time: this name selects the first message");
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

/// Sets the frame format of each message (CAN or CAN FD) from its attribute VFrameFormat. If the message does
/// not have this attribute, the default of VFrameFormat applies. If the DBC has no default either, a message
/// of 9 to 64 bytes is CAN FD and all others are CAN. Sets the bit-rate switch of CAN FD messages from
/// CANFD_BRS in the same way; if the DBC has no default, it is on.
void Reader::set_frame_formats() {
  const auto by_default = [this](const char* name, auto meaning) -> std::optional<bool> {
    const auto defined = attributes_.find(name);
    if (defined == attributes_.end() || !defined->second.default_value) return std::nullopt;
    return meaning(*defined->second.default_value);
  };
  const std::optional<bool> fd = by_default(frame_format, is_fd), brs = by_default(bit_rate_switch, switches);
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    Message& message = database_.messages[i];
    message.fd = texts_[i].fd.value_or(fd.value_or(message.fd));
    message.bit_rate_switch = message.fd && texts_[i].switches.value_or(brs.value_or(true));
  }
}

}  // namespace hystcan::can::dbc
