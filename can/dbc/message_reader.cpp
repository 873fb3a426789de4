#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "can/dbc/reader.h"
#include "can/dbc/text.h"

namespace hystcan::can::dbc {
namespace {

constexpr std::uint64_t extended_flag = 0x8000'0000;
constexpr std::uint64_t max_standard_id = 0x7FF;
constexpr std::uint64_t max_extended_id = 0x1FFF'FFFF;
constexpr std::uint64_t max_message_bytes = 0xFFFF;
constexpr std::uint64_t max_length = 0xFFFF;  // bits; a signal of more than 64 bits is kept but not decoded
constexpr std::uint64_t max_signal_bits = 64;
constexpr std::uint16_t max_classical_bytes = 8;
constexpr std::uint16_t max_fd_bytes = 64;

[[noreturn]] void refuse(Token at, std::string found, std::string expected) {
  throw ParseError{at.text.data(), std::move(found), std::move(expected)};
}

double finite(Token token, const std::string& what) {
  const auto number = to_real(token.text);
  if (!number || !std::isfinite(*number)) refuse(token, cited(token), what + " that a double can hold");
  return *number;
}

class SignalReader {
 public:
  SignalReader(const SignalLine& line, Warnings& warnings)
      : line_(line), warnings_(warnings), of_(" of signal " + std::string(line.name.text)) {}

  Signal read() {
    Signal signal;
    signal.name = to_utf8(line_.name.text);
    signal.multiplexing = multiplexing();
    signal.start_bit = static_cast<std::uint32_t>(
        natural(line_.start_bit, 0, 8 * max_message_bytes - 1, "a start bit" + of_));
    signal.length = static_cast<std::uint16_t>(natural(line_.length, 0, max_length, "a length" + of_));
    signal.byte_order = line_.byte_order.text == "1" ? ByteOrder::little_endian : ByteOrder::big_endian;
    signal.is_signed = line_.sign.text == "-";
    signal.scale = finite(line_.scale, "a scale" + of_);
    signal.offset = finite(line_.offset, "an offset" + of_);
    signal.unit = unescaped(line_.unit.text);
    for (const Token& receiver : line_.receivers) signal.receivers.push_back(to_utf8(receiver.text));
    if (signal.length < 1 || signal.length > max_signal_bits) {
      note(line_.length,
           "a length of " + std::to_string(signal.length) + " bits" + of_ + ": it is not decoded");
    }
    if (signal.scale == 0.0) note(line_.scale, "a scale of 0" + of_ + ": it can't be encoded");
    read_range(signal);
    return signal;
  }

 private:
  void note(Token at, std::string what) { warnings_.add(at, std::move(what)); }

  /// A switch is `M` or `m3M`. Some tools write `m` and `m3m`.
  Multiplexing multiplexing() {
    Multiplexing result;
    std::string_view text = line_.multiplexing.text;
    if (text.empty()) return result;
    const bool small = text == "m" || (text.ends_with('m') && text.size() > 2);
    result.is_switch = small || text.ends_with('M');
    if (small) note(line_.multiplexing, "the switch" + of_ + " is marked with m: read as M");
    if (result.is_switch) text.remove_suffix(1);
    if (text.empty()) return result;
    const auto value = text.starts_with('m') ? to_natural(text.substr(1)) : std::nullopt;
    if (!value || *value > 0xFFFF'FFFF) {
      refuse(line_.multiplexing, cited(line_.multiplexing), "M, m and a number, or ':' after the name" + of_);
    }
    result.present_at = static_cast<std::uint32_t>(*value);
    return result;
  }

  void read_range(Signal& signal) {
    const auto minimum = to_real(line_.minimum.text);
    const auto maximum = to_real(line_.maximum.text);
    if (!minimum) refuse(line_.minimum, cited(line_.minimum), "a minimum" + of_);
    if (!maximum) refuse(line_.maximum, cited(line_.maximum), "a maximum" + of_);
    if (*minimum <= *maximum) {
      signal.minimum = *minimum;
      signal.maximum = *maximum;
      return;
    }
    note(line_.minimum, "minimum " + std::string(line_.minimum.text) + " and maximum " +
                            std::string(line_.maximum.text) + of_ + " are not a range: read as no range");
  }

  const SignalLine& line_;
  Warnings& warnings_;
  std::string of_;
};

class MessageReader {
 public:
  MessageReader(const MessageBlock& block, Warnings& warnings) : block_(block), warnings_(warnings) {}

  Message read() {
    message_.name = to_utf8(block_.name.text);
    message_.sender = to_utf8(block_.sender.text);
    read_identifier();
    message_.length = static_cast<std::uint16_t>(
        natural(block_.length, 0, max_message_bytes, "a length of message " + message_.name + " in bytes"));
    message_.fd = message_.length > max_classical_bytes && message_.length <= max_fd_bytes;
    message_.signals.reserve(block_.signals.size());
    for (const SignalLine& line : block_.signals) add_signal(line);
    find_switch();
    note_overlaps();
    return std::move(message_);
  }

 private:
  void note(Token at, std::string what) { warnings_.add(at, std::move(what)); }

  void read_identifier() {
    const std::uint64_t id = natural(block_.id, 0, 0xFFFF'FFFF, "the identifier of a message");
    message_.extended = (id & extended_flag) != 0;
    message_.id = static_cast<std::uint32_t>(id & ~extended_flag);
    if (message_.id > max_extended_id) {
      refuse(block_.id, cited(block_.id), "an identifier of 11 bits, or of 29 bits with bit 31 set");
    }
    if (message_.extended || message_.id <= max_standard_id) return;
    message_.extended = true;
    note(block_.id, "identifier " + std::string(block_.id.text) + " of message " + message_.name +
                        " has more than 11 bits, but not bit 31: read as extended");
  }

  void add_signal(const SignalLine& line) {
    Signal signal = SignalReader(line, warnings_).read();
    if (!names_.insert(line.name.text).second && !signal.multiplexing.present_at) {
      note(line.name,
           "signal " + signal.name + " occurs a second time in message " + message_.name + ": both are kept");
    }
    if (bytes_needed(signal) > message_.length) {
      note(line.start_bit, "signal " + signal.name + " reaches beyond the " +
                               std::to_string(message_.length) + " bytes of message " + message_.name);
    }
    message_.signals.push_back(std::move(signal));
  }

  /// Simple multiplexing: every `m` depends on the `M` of the message. Without an `M` it is always present.
  void find_switch() {
    auto& all = message_.signals;
    const auto is_first = [](const Signal& signal) {
      return signal.multiplexing.is_switch && !signal.multiplexing.present_at;
    };
    const auto found = std::find_if(all.begin(), all.end(), is_first);
    if (found == all.end()) return;
    const auto index = static_cast<std::size_t>(found - all.begin());
    for (Signal& signal : all) {
      Multiplexing& multiplexing = signal.multiplexing;
      if (!multiplexing.present_at) continue;
      multiplexing.switched_by = index;
      multiplexing.ranges = {{*multiplexing.present_at, *multiplexing.present_at}};
    }
  }

  /// Notes overlaps among the signals that are always present and not too long to be decoded.
  void note_overlaps() {
    if (message_.signals.size() < 2) return;
    std::vector<bool> taken(8U * std::size_t{message_.length});
    for (std::size_t i = 0; i < message_.signals.size(); ++i) {
      const Signal& signal = message_.signals[i];
      if (signal.length > max_signal_bits || signal.multiplexing.present_at) continue;
      if (bytes_needed(signal) > message_.length) continue;
      const bool little = signal.byte_order == ByteOrder::little_endian;
      const std::size_t first = little ? signal.start_bit : signal.start_bit ^ 7U;  // in wire order
      bool overlaps = false;
      for (std::size_t bit = first; bit < first + signal.length; ++bit) {
        const std::size_t place = little ? bit : bit ^ 7U;
        overlaps = overlaps || taken[place];
        taken[place] = true;
      }
      if (overlaps) {
        note(block_.signals[i].name,
             "signal " + signal.name + " overlaps another one of message " + message_.name);
      }
    }
  }

  const MessageBlock& block_;
  Warnings& warnings_;
  Message message_;
  std::set<std::string_view> names_;
};

}  // namespace

std::string cited(Token token) {
  constexpr std::size_t most = 60;
  const bool whole = token.text.size() <= most;
  return '\'' + std::string(token.text.substr(0, most)) + (whole ? "'" : "...'");
}

std::uint64_t natural(Token token, std::uint64_t minimum, std::uint64_t maximum, const std::string& what) {
  const auto number = to_natural(token.text);
  if (!number || *number < minimum || *number > maximum) {
    refuse(token, cited(token), what + " from " + std::to_string(minimum) + " to " + std::to_string(maximum));
  }
  return *number;
}

Message read_message(const MessageBlock& block, Warnings& warnings) {
  return MessageReader(block, warnings).read();
}

}  // namespace hystcan::can::dbc
