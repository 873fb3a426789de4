#include "can/dbc/message_decoder.h"

#include <algorithm>
#include <functional>

#include "can/dbc/signal_codec.h"

namespace hystcan::can {
namespace {

bool can_be_read(const Signal& signal, std::span<const std::uint8_t> payload) {
  return is_decodable(signal) && bytes_needed(signal) <= payload.size();
}

std::uint64_t bits_of(const Signal& signal, std::span<const std::uint8_t> payload) {
  const auto raw = static_cast<std::uint64_t>(SignalCodec(signal).unpack_raw(payload));
  return raw & ~std::uint64_t{0} >> (64U - signal.length);
}

/// Determines which signals of a message a payload contains. A multiplexed signal is present if its switch
/// signal is present and the payload has one of the signal's values for the switch. Switches may form chains
/// of any length; signals that switch each other in a ring are never present.
class Presence {
 public:
  Presence(const Message& message, std::span<const std::uint8_t> payload)
      : signals_(message.signals), payload_(payload), known_(message.signals.size()) {}

  bool of(std::size_t asked) {
    std::size_t index = asked;
    while (!known_[index]) {  // follows the chain of switches to its end or to a signal with a known result
      known_[index] = false;  // preliminary result; stays false if the switches form a ring
      chain_.push_back(index);
      const auto& switched_by = signals_[index].multiplexing.switched_by;
      if (!switched_by) break;
      index = *switched_by;
    }
    for (; !chain_.empty(); chain_.pop_back()) known_[chain_.back()] = is_present(signals_[chain_.back()]);
    return known_[asked] == true;
  }

 private:
  using Range = Multiplexing::Range;

  bool is_present(const Signal& signal) const {
    if (!can_be_read(signal, payload_)) return false;
    const Multiplexing& multiplexing = signal.multiplexing;
    if (!multiplexing.switched_by) return true;
    if (known_[*multiplexing.switched_by] != true) return false;
    const std::uint64_t reads = bits_of(signals_[*multiplexing.switched_by], payload_);
    const auto range = std::ranges::lower_bound(multiplexing.ranges, reads, std::less<>{}, &Range::high);
    return range != multiplexing.ranges.end() && range->low <= reads;
  }

  const std::vector<Signal>& signals_;
  std::span<const std::uint8_t> payload_;
  std::vector<std::optional<bool>> known_;  ///< for each signal: true if present; nullopt: not yet known
  std::vector<std::size_t> chain_;
};

DecodedSignal decode(const Signal& signal, std::span<const std::uint8_t> payload) {
  const SignalCodec codec(signal);
  DecodedSignal decoded{&signal, codec.unpack_raw(payload), codec.unpack(payload), {}};
  const auto named = signal.values.find(decoded.raw);
  if (named != signal.values.end()) decoded.name = named->second;
  return decoded;
}

}  // namespace

const Message* message_of(const Database& database, const Frame& frame) {
  if (frame.kind == FrameKind::error) return nullptr;
  const auto found = database.message_by_id.find(Database::key_of(frame.id, frame.extended));
  return found == database.message_by_id.end() ? nullptr : &database.messages[found->second];
}

std::vector<DecodedSignal> decode_signals(const Message& message, const Frame& frame) {
  std::vector<DecodedSignal> decoded;
  if (frame.kind == FrameKind::remote || frame.kind == FrameKind::error) return decoded;
  decoded.reserve(message.signals.size());
  Presence presence(message, frame.payload());
  for (std::size_t i = 0; i < message.signals.size(); ++i) {
    if (presence.of(i)) decoded.push_back(decode(message.signals[i], frame.payload()));
  }
  return decoded;
}

}  // namespace hystcan::can
