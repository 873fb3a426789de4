#include "can/dbc.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

#include "can/dbc_grammar.h"

namespace hystcan::can {
namespace {

using dbc::Mistake;
using dbc::Token;

constexpr std::uint64_t extended_flag = 0x8000'0000;
constexpr std::uint64_t independent_signals_id = 0xC000'0000;
constexpr std::string_view independent_signals_name = "VECTOR__INDEPENDENT_SIG_MSG";
constexpr std::uint64_t max_message_bytes = 64;
constexpr std::uint64_t max_signal_bits = 64;

std::string cited(Token token) { return '\'' + std::string(token.text) + '\''; }

[[noreturn]] void refuse(Token at, std::string found, std::string expected) {
  throw Mistake{at.text.data(), std::move(found), std::move(expected)};
}

template <class Number>
bool convert(std::string_view text, Number& number) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

std::uint64_t natural(Token token, std::uint64_t minimum, std::uint64_t maximum, const std::string& what) {
  std::uint64_t number = 0;
  if (!convert(token.text, number) || number < minimum || number > maximum) {
    refuse(token, cited(token), what + " from " + std::to_string(minimum) + " to " + std::to_string(maximum));
  }
  return number;
}

double real(Token token, const std::string& what) {
  double number = 0.0;
  if (!convert(token.text, number)) refuse(token, cited(token), what + " that a double can hold");
  return number;
}

/// Beyond the signed range a raw value stands for the same 64 bits.
std::int64_t raw_value(Token token) {
  std::int64_t number = 0;
  if (convert(token.text, number)) return number;
  std::uint64_t bits = 0;
  if (!convert(token.text, bits)) refuse(token, cited(token), "a raw value of at most 64 bits");
  return static_cast<std::int64_t>(bits);
}

std::string unescaped(Token token) {
  std::string text(token.text);
  for (auto at = text.find("\\\""); at != std::string::npos; at = text.find("\\\"", at + 1))
    text.erase(at, 1);
  return text;
}

Multiplexing read_multiplexing(Token token) {
  Multiplexing result;
  std::string_view text = token.text;
  result.is_switch = text.ends_with('M');
  if (!text.starts_with('m')) return result;
  text.remove_prefix(1);
  if (result.is_switch) text.remove_suffix(1);
  result.present_at = static_cast<std::uint32_t>(natural(Token{text}, 0, 0xFFFF'FFFF, "a multiplexer value"));
  return result;
}

Signal read_signal(const dbc::SignalLine& line) {
  const std::string of_signal = " of signal " + std::string(line.name.text);
  Signal signal;
  signal.name = line.name.text;
  signal.multiplexing = read_multiplexing(line.multiplexing);
  signal.start_bit = static_cast<std::uint16_t>(
      natural(line.start_bit, 0, 8 * max_message_bytes - 1, "a start bit" + of_signal));
  signal.length =
      static_cast<std::uint16_t>(natural(line.length, 1, max_signal_bits, "a length" + of_signal));
  signal.byte_order = line.byte_order.text == "1" ? ByteOrder::little_endian : ByteOrder::big_endian;
  signal.is_signed = line.sign.text == "-";
  signal.scale = real(line.scale, "a scale" + of_signal);
  signal.offset = real(line.offset, "an offset" + of_signal);
  signal.minimum = real(line.minimum, "a minimum" + of_signal);
  signal.maximum = real(line.maximum, "a maximum" + of_signal);
  signal.unit = unescaped(line.unit);
  for (const Token& receiver : line.receivers) signal.receivers.emplace_back(receiver.text);
  if (signal.scale == 0.0) refuse(line.scale, cited(line.scale), "a scale" + of_signal + " other than 0");
  if (signal.minimum > signal.maximum) {
    refuse(line.minimum,
           "minimum " + std::string(line.minimum.text) + " above maximum " + std::string(line.maximum.text),
           "a range" + of_signal + " from low to high");
  }
  return signal;
}

/// Bits of the payload before which the signal ends, counted along the wire for big-endian ones.
unsigned end_of(const Signal& signal) {
  if (signal.byte_order == ByteOrder::little_endian) return signal.start_bit + 0U + signal.length;
  return 8U * (signal.start_bit / 8U) + 7U - signal.start_bit % 8U + signal.length;
}

class Reader {
 public:
  explicit Reader(const dbc::Document& document) {
    database_.version = unescaped(document.version);
    for (const Token& node : document.nodes) database_.nodes.emplace_back(node.text);
    for (const auto& block : document.messages) add_message(block);
    for (const auto& comment : document.message_comments) {
      if (Message* message = find(comment.id)) message->comment = unescaped(comment.text);
    }
    for (const auto& comment : document.signal_comments) {
      if (Signal* signal = find(comment.id, comment.signal)) signal->comment = unescaped(comment.text);
    }
    for (const auto& values : document.values) add_values(values);
    for (const auto& type : document.value_types) set_value_type(type);
  }

  Database take() { return std::move(database_); }

 private:
  void add_message(const dbc::MessageBlock& block) {
    const std::uint64_t id = natural(block.id, 0, 0xFFFF'FFFF, "the identifier of a message");
    if (id == independent_signals_id || block.name.text == independent_signals_name) return;
    Message message;
    message.extended = (id & extended_flag) != 0;
    message.id = static_cast<std::uint32_t>(id & ~extended_flag);
    message.name = block.name.text;
    message.sender = block.sender.text;
    if (message.id > (message.extended ? 0x1FFF'FFFFU : 0x7FFU)) {
      refuse(block.id, cited(block.id), "an identifier of 11 bits, or of 29 bits with bit 31 set");
    }
    message.length = static_cast<std::uint8_t>(
        natural(block.length, 0, max_message_bytes, "a length of message " + message.name + " in bytes"));
    if (!index_.emplace(id, database_.messages.size()).second) {
      refuse(block.id, "identifier " + std::string(block.id.text) + " a second time", "each message's own");
    }
    if (!names_.insert(block.name.text).second) {
      refuse(block.name, "message " + message.name + " a second time", "each name once");
    }
    add_signals(block, message);
    database_.messages.push_back(std::move(message));
  }

  static void add_signals(const dbc::MessageBlock& block, Message& message) {
    std::set<std::string_view> names;
    for (const auto& line : block.signals) {
      if (!names.insert(line.name.text).second) {
        refuse(line.name, "signal " + std::string(line.name.text) + " a second time",
               "each name once in message " + message.name);
      }
      Signal signal = read_signal(line);
      if (end_of(signal) > 8U * message.length) {
        refuse(line.start_bit, std::string(line.start_bit.text) + '|' + std::string(line.length.text),
               "signal " + signal.name + " inside the " + std::to_string(message.length) +
                   " bytes of message " + message.name);
      }
      message.signals.push_back(std::move(signal));
    }
  }

  void add_values(const dbc::SignalValues& values) {
    Signal* signal = find(values.id, values.signal);
    if (signal == nullptr) return;
    for (const auto& [raw, name] : values.names) signal->values[raw_value(raw)] = unescaped(name);
  }

  void set_value_type(const dbc::SignalValueType& line) {
    constexpr std::array types = {ValueType::integer, ValueType::float32, ValueType::float64};
    const std::uint64_t type = natural(line.type, 0, 3, "a value type");
    Signal* signal = find(line.id, line.signal);
    if (signal == nullptr || type >= types.size()) return;
    const unsigned bits = type == 2 ? 64 : 32;
    if (type != 0 && signal->length != bits) {
      refuse(line.type, cited(line.type),
             "signal " + signal->name + " of " + std::to_string(bits) + " bits to be a number of this type");
    }
    signal->value_type = types[type];
  }

  Message* find(Token id) {
    const auto found = index_.find(natural(id, 0, 0xFFFF'FFFF, "the identifier of a message"));
    return found == index_.end() ? nullptr : &database_.messages[found->second];
  }

  Signal* find(Token id, Token name) {
    Message* message = find(id);
    if (message == nullptr) return nullptr;
    const auto found = std::find_if(message->signals.begin(), message->signals.end(),
                                    [&](const Signal& signal) { return signal.name == name.text; });
    return found == message->signals.end() ? nullptr : &*found;
  }

  Database database_;
  std::map<std::uint64_t, std::size_t> index_;  ///< by identifier as the DBC writes it
  std::set<std::string_view> names_;
};

std::string locate(std::string_view text, const char* where, const std::string& file_name) {
  const auto before = text.substr(0, static_cast<std::size_t>(where - text.data()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const auto column = before.size() - (before.rfind('\n') + 1) + 1;  // npos + 1 is 0
  return file_name + ':' + std::to_string(line) + ':' + std::to_string(column);
}

}  // namespace

const Signal* Message::find(std::string_view signal) const {
  const auto found =
      std::find_if(signals.begin(), signals.end(), [&](const Signal& each) { return each.name == signal; });
  return found == signals.end() ? nullptr : &*found;
}

const Message* Database::find(std::string_view message) const {
  const auto found = std::find_if(messages.begin(), messages.end(),
                                  [&](const Message& each) { return each.name == message; });
  return found == messages.end() ? nullptr : &*found;
}

Database parse_dbc(std::string_view text, const std::string& file_name) {
  if (constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF"; text.starts_with(byte_order_mark)) {
    text.remove_prefix(byte_order_mark.size());
  }
  try {
    return Reader(dbc::parse_document(text)).take();
  } catch (const Mistake& mistake) {
    throw DbcError(locate(text, mistake.where, file_name) + ": found " + mistake.found + ", expected " +
                   mistake.expected);
  }
}

Database load_dbc(const std::filesystem::path& file) {
  const auto refuse_file = [&](int error) {
    throw DbcError(file.string() + ": cannot be read: " + std::strerror(error));
  };
  std::ifstream stream(file, std::ios::binary);
  if (!stream) refuse_file(errno);
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) refuse_file(EISDIR);
  std::ostringstream text;
  text << stream.rdbuf();
  if (stream.bad()) refuse_file(EIO);
  return parse_dbc(text.str(), file.string());
}

}  // namespace hystcan::can
