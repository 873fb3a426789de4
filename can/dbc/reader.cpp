#include "can/dbc/reader.h"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "can/dbc/cursor.h"
#include "can/dbc/text.h"

namespace hystcan::can::dbc {
namespace {

constexpr std::uint64_t independent_signals_id = 0xC000'0000;
constexpr std::string_view independent_signals_name = "VECTOR__INDEPENDENT_SIG_MSG";

/// The sections after the messages name them by identifier and name. If several messages or signals have the
/// same identifier or name, the section applies to all of them.
class Reader {
 public:
  explicit Reader(Document& document)
      : document_(document),
        warnings_(document.warnings),
        attributes_(database_, document.warnings, copies_) {}

  Database run() {
    database_.version = unescaped(document_.version.text);
    for (const Token& node : document_.nodes) add_node(node);
    database_.messages.reserve(document_.messages.size());
    for (const MessageBlock& block : document_.messages) add_message(block);
    signals_.resize(database_.messages.size());
    for (const ValueTable& table : document_.value_tables)
      add_names(table.names, database_.value_tables[to_utf8(table.name.text)]);
    for (const Comment& comment : document_.comments) add_comment(comment);
    for (const SignalValues& values : document_.values) add_values(values);
    for (const SignalValueType& type : document_.value_types) set_value_type(type);
    for (const SignalMultiplexing& line : document_.multiplexing) set_multiplexing(line);
    for (const AttributeDefinition& definition : document_.definitions) attributes_.define(definition);
    for (const AttributeDefault& line : document_.defaults) attributes_.set_default(line);
    for (const AttributeLine& line : document_.attributes) set_attribute(line);
    for (const AttributeLine& line : document_.attributes) set_long_name(line);
    finish_long_names(database_, blocks_, warnings_, copies_);
    for (const RelationLine& line : document_.relations) add_relation(line);
    attributes_.derive();
    return std::move(database_);
  }

 private:
  void note(Token at, std::string what) { warnings_.add(at, std::move(what)); }

  // ---- nodes and messages

  void add_node(Token node) {
    if (!nodes_.emplace(node.text, database_.nodes.size()).second) {
      note(node, "node " + std::string(node.text) + " occurs a second time");
      return;
    }
    database_.nodes.push_back({to_utf8(node.text), {}, {}, {}});
  }

  void add_message(const MessageBlock& block) {
    const std::uint64_t id = natural(block.id, 0, 0xFFFF'FFFF, "the identifier of a message");
    if (id == independent_signals_id || block.name.text == independent_signals_name) {
      left_out_ = id;
      return;
    }
    const std::size_t index = database_.messages.size();
    Message message = read_message(block, warnings_);
    if (!names_.emplace(block.name.text, index).second) {
      note(block.name, "message " + message.name + " occurs a second time: its name finds the first");
    }
    if (!database_.message_by_id.insert_or_assign(Database::key_of(message.id, message.extended), index)
             .second) {
      note(block.id, "identifier " + std::string(block.id.text) +
                         " occurs a second time: the last message decodes its frames");
    }
    by_id_.emplace(id, index);
    blocks_.push_back(&block);
    database_.messages.push_back(std::move(message));
  }

  // ---- search by identifier and name

  /// `bytes`: what is copied to each object.
  template <class Do>
  void for_messages(Token id_token, std::size_t bytes, Do&& act) {
    const std::uint64_t id = natural(id_token, 0, 0xFFFF'FFFF, "the identifier of a message");
    const auto [first, last] = by_id_.equal_range(id);
    if (first == last && id != left_out_) note(id_token, "there is no message " + std::string(id_token.text));
    for (auto each = first; each != last; ++each) {
      if (each != first) copies_.take(id_token, bytes_of_an_entry + bytes);
      act(each->second);
    }
  }

  template <class Do>
  void for_signals(Token id, Token name, std::size_t bytes, Do&& act) {
    for_messages(id, bytes, [&](std::size_t index) {
      Message& message = database_.messages[index];
      const auto [first, last] = signals_named(index, name);
      if (first == last) {
        note(name, "message " + message.name + " has no signal " + std::string(name.text));
      }
      for (auto each = first; each != last; ++each) {
        if (each != first) copies_.take(name, bytes_of_an_entry + bytes);
        act(message, message.signals[each->second]);
      }
    });
  }

  using SignalIndex = std::multimap<std::string_view, std::size_t>;  ///< by the name in the text
  std::pair<SignalIndex::const_iterator, SignalIndex::const_iterator> signals_named(std::size_t index,
                                                                                    Token token) {
    SignalIndex& signals = signals_[index];
    if (signals.empty()) {
      const std::vector<SignalLine>& lines = blocks_[index]->signals;
      for (std::size_t i = 0; i < lines.size(); ++i) signals.emplace(lines[i].name.text, i);
    }
    return std::as_const(signals).equal_range(token.text);
  }

  Node* node(Token name) {
    const auto found = nodes_.find(name.text);
    if (found != nodes_.end()) return &database_.nodes[found->second];
    if (name.text != "Vector__XXX") note(name, "there is no node " + std::string(name.text));
    return nullptr;
  }

  // ---- comments, values, types, multiplexing and attributes

  void add_comment(const Comment& comment) {
    const std::string text = unescaped(comment.text.text);
    const Subject& subject = comment.subject;
    switch (subject.kind) {
      case Subject::Kind::network:
        database_.comment = text;
        break;
      case Subject::Kind::node:
        if (Node* found = node(subject.name)) found->comment = text;
        break;
      case Subject::Kind::message:
        for_messages(subject.id, text.size(),
                     [&](std::size_t index) { database_.messages[index].comment = text; });
        break;
      case Subject::Kind::signal:
        for_signals(subject.id, subject.name, text.size(),
                    [&](Message&, Signal& signal) { signal.comment = text; });
        break;
      case Subject::Kind::environment:
        break;
    }
  }

  /// A raw value above the signed range means the signed value with the same 64 bits.
  void add_names(const std::vector<ValueName>& names, std::map<std::int64_t, std::string>& values) {
    for (const auto& [raw, name] : names) {
      const auto natural_value = to_natural(raw.text);
      const auto value = natural_value ? static_cast<std::int64_t>(*natural_value) : to_integer(raw.text);
      if (value) {
        values[*value] = unescaped(name.text);
      } else {
        note(raw, cited(raw) + " is not a raw value of at most 64 bits: left out");
      }
    }
  }

  static std::size_t bytes_of(const std::map<std::int64_t, std::string>& names) {
    std::size_t bytes = 0;
    for (const auto& [raw, name] : names) bytes += bytes_of_an_entry + name.size();
    return bytes;
  }

  void add_values(const SignalValues& values) {
    std::map<std::int64_t, std::string> names;
    if (!values.table.text.empty()) {
      const auto table = database_.value_tables.find(to_utf8(values.table.text));
      if (table == database_.value_tables.end()) {
        note(values.table, "there is no value table " + std::string(values.table.text));
      } else {
        copies_.take(values.table, bytes_of(table->second));
        names = table->second;
      }
    }
    add_names(values.names, names);
    for_signals(values.id, values.signal, bytes_of(names), [&](Message&, Signal& signal) {
      for (const auto& [raw, name] : names) signal.values.insert_or_assign(raw, name);
    });
  }

  /// The length decides between the two types, because real files confuse them.
  void set_value_type(const SignalValueType& line) {
    const std::uint64_t type = natural(line.type, 0, 3, "a value type");
    for_signals(line.id, line.signal, 0, [&](Message&, Signal& signal) {
      if (type != 1 && type != 2) return;
      const bool fits = signal.length == 32 || signal.length == 64;
      if (!fits || signal.length != 32 * type) {
        note(line.type, "signal " + signal.name + " of " + std::to_string(signal.length) +
                            " bits can't have value type " + std::to_string(type) +
                            (fits ? ": its length decides" : ": it is not decoded"));
      }
      signal.value_type = !fits                 ? ValueType::unreadable
                          : signal.length == 32 ? ValueType::float32
                                                : ValueType::float64;
    });
  }

  void set_multiplexing(const SignalMultiplexing& line) {
    const auto ranges = ranges_of(line);
    for_messages(line.id, bytes_of_an_entry * ranges.size(), [&](std::size_t index) {
      Message& message = database_.messages[index];
      const auto [first, last] = signals_named(index, line.signal);
      const auto [first_switch, last_switch] = signals_named(index, line.multiplexer);
      if (first == last || first_switch == last_switch) {
        const Token& missing = first == last ? line.signal : line.multiplexer;
        note(missing, "message " + message.name + " has no signal " + std::string(missing.text));
        return;
      }
      const bool alone = std::next(first) == last;
      for (auto each = first; each != last; ++each) {
        if (each != first) copies_.take(line.signal, bytes_of_an_entry);
        Multiplexing& multiplexing = message.signals[each->second].multiplexing;
        multiplexing.switched_by = first_switch->second;
        if (alone) multiplexing.ranges = ranges;
      }
      message.signals[first_switch->second].multiplexing.is_switch = true;
    });
  }

  /// The same values, in ranges that ascend and do not overlap.
  static std::vector<Multiplexing::Range> disjoint(std::vector<Multiplexing::Range> ranges) {
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

  std::vector<Multiplexing::Range> ranges_of(const SignalMultiplexing& line) {
    std::vector<Multiplexing::Range> ranges;
    ranges.reserve(line.ranges.size());
    for (const auto& [low, high] : line.ranges) {
      const Multiplexing::Range range{natural(low, 0, ~std::uint64_t{0}, "a multiplexer value"),
                                      natural(high, 0, ~std::uint64_t{0}, "a multiplexer value")};
      if (range.low > range.high) {
        note(low, "no value lies from " + std::string(low.text) + " to " + std::string(high.text));
      } else {
        ranges.push_back(range);
      }
    }
    return disjoint(std::move(ranges));
  }

  static std::size_t bytes_of(const std::string& name, const AttributeValue& value) {
    const auto* text = std::get_if<std::string>(&value);
    return name.size() + (text != nullptr ? text->size() : 0);
  }

  void set_attribute(const AttributeLine& line) {
    const std::string name = unescaped(line.name.text);
    const AttributeValue value = attributes_.value_of(line.name, line.value);
    const Subject& subject = line.subject;
    switch (subject.kind) {
      case Subject::Kind::network:
        database_.attributes.insert_or_assign(name, value);
        break;
      case Subject::Kind::node:
        if (Node* found = node(subject.name)) found->attributes.insert_or_assign(name, value);
        break;
      case Subject::Kind::message:
        for_messages(subject.id, bytes_of(name, value), [&](std::size_t index) {
          database_.messages[index].attributes.insert_or_assign(name, value);
        });
        break;
      case Subject::Kind::signal:
        for_signals(subject.id, subject.name, bytes_of(name, value),
                    [&](Message&, Signal& signal) { signal.attributes.insert_or_assign(name, value); });
        break;
      case Subject::Kind::environment:
        break;
    }
  }

  // ---- long names

  /// Names of more than 32 characters stand shortened in the file, and whole in an attribute.
  void set_long_name(const AttributeLine& line) {
    using Kind = Subject::Kind;
    const Subject& subject = line.subject;
    const std::string_view attribute = line.name.text;
    const bool names_it = (subject.kind == Kind::message && attribute == "SystemMessageLongSymbol") ||
                          (subject.kind == Kind::signal && attribute == "SystemSignalLongSymbol") ||
                          (subject.kind == Kind::node && attribute == "SystemNodeLongSymbol");
    const Token given = line.value.token;
    if (!names_it || given.text.empty()) return;
    if (given.text.size() > longest_name || !Cursor::is_word(given.text)) {
      return note(given, cited(given) + " is not a name: the name in the file stays");
    }
    const std::string name = to_utf8(given.text);
    if (subject.kind == Kind::message) {
      for_messages(subject.id, name.size(),
                   [&](std::size_t index) { rename(database_.messages[index], name); });
    } else if (subject.kind == Kind::signal) {
      for_signals(subject.id, subject.name, name.size(),
                  [&](Message&, Signal& signal) { rename(signal, name); });
    } else if (Node* found = node(subject.name)) {
      rename(*found, name);
    }
  }

  template <class Named>
  static void rename(Named& named, const std::string& name) {
    if (named.short_name.empty()) named.short_name = named.name;
    named.name = name;
  }

  /// The names of the objects are the long ones.
  void add_relation(const RelationLine& line) {
    RelationAttribute relation{unescaped(line.name.text),
                               to_utf8(line.node.text),
                               {},
                               to_utf8(line.subject.name.text),
                               attributes_.value_of(line.name, line.value)};
    const auto found = nodes_.find(line.node.text);
    if (found != nodes_.end()) relation.node = database_.nodes[found->second].name;
    copies_.take(line.node, relation.node.size());
    if (!line.subject.id.text.empty()) {
      for_messages(line.subject.id, 0, [&](std::size_t index) {
        const Message& message = database_.messages[index];
        copies_.take(line.subject.id, message.name.size());
        relation.message = message.name;
        const auto [first, last] = signals_named(index, line.subject.name);
        if (first == last) return;
        const Signal& signal = message.signals[first->second];
        copies_.take(line.subject.name, signal.name.size());
        relation.object = signal.name;
      });
    }
    database_.relation_attributes.push_back(std::move(relation));
  }

  Document& document_;
  Warnings& warnings_;
  Database database_;
  Copies copies_;
  AttributeReader attributes_;
  // Trees, because the keys of a hash table can be chosen so that each search visits all of them.
  std::map<std::string_view, std::size_t> nodes_;
  std::map<std::string_view, std::size_t> names_;    ///< index of each message
  std::multimap<std::uint64_t, std::size_t> by_id_;  ///< by the identifier in the DBC
  std::vector<const MessageBlock*> blocks_;          ///< the text of each message
  std::vector<SignalIndex> signals_;                 ///< for each message, made at its first use
  std::optional<std::uint64_t> left_out_;            ///< Vector's message without a frame
};

}  // namespace

Database read_document(Document& document) { return Reader(document).run(); }

}  // namespace hystcan::can::dbc
