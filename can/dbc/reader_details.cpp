// The sections that say more about messages and signals: comments, names of values, types, extended
// multiplexing.
#include <algorithm>

#include "can/dbc/reader.h"
#include "can/dbc/text.h"

namespace hystcan::can::dbc {
namespace {

std::size_t bytes_of(const std::map<std::int64_t, std::string>& names) {
  std::size_t bytes = 0;
  for (const auto& [raw, name] : names) bytes += bytes_of_an_entry + name.size();
  return bytes;
}

/// The same values, in ranges that ascend and do not overlap.
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
  const std::string_view text = cursor_.need_quoted(quoted_text, longest_text);
  need_semicolon();
  details_.emplace_back([this, of, text] {
    const std::string comment = unescaped(text);
    for_objects(of, comment.size(), [&](auto& object) { object.comment = comment; });
  });
}

/// A raw value above the signed range means the signed value with the same 64 bits.
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
      note(*raw, cited(*raw) + " is not a raw value of at most 64 bits: left out");
    cursor_.take(',');
  }
  return names;
}

void Reader::value_table() {
  const std::string_view name = cursor_.need_word("the name of a value table");
  Names& table = database_.value_tables[to_utf8(name)];
  for (const auto& [raw, value] : value_names()) table[raw] = value;
  need_semicolon();
}

/// The values of a signal or of an environment variable, which has no message.
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
  std::string_view table;  // instead of names
  if (cursor_.next() != ';' && !is_section(cursor_.peek_word())) table = cursor_.take_word().value_or("");
  need_semicolon();
  details_.emplace_back([this, id, signal, table, names] { set_values(id, signal, table, names); });
}

void Reader::set_values(std::string_view id, std::string_view signal, std::string_view table, Names names) {
  if (!table.empty()) {
    const auto found = database_.value_tables.find(to_utf8(table));
    if (found == database_.value_tables.end()) {
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

/// The length decides between the two types, because real files confuse them.
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
      if (!fits || each.length != 32 * type) {
        note(token, "signal " + each.name + " of " + std::to_string(each.length) +
                        " bits can't have value type " + std::to_string(type) +
                        (fits ? ": its length decides" : ": it is not decoded"));
      }
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
      note(low, "no value lies from " + std::string(low) + " to " + std::string(high));
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
    const auto found_switch = signals.find(by);  // the first of this name
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

}  // namespace hystcan::can::dbc
