// Placeholder until branch dbc5 is merged, whose message_decoder.cpp replaces this file: no SG_MUL_VAL_.
#include "can/message_decoder.h"

#include <algorithm>

#include "can/codec.h"

namespace hystcan::can {

const Message* message_of(const Database& database, const Frame& frame) {
  if (frame.kind == FrameKind::error) return nullptr;
  const auto found = std::find_if(database.messages.begin(), database.messages.end(), [&](const Message& m) {
    return m.id == frame.id && m.extended == frame.extended;
  });
  return found == database.messages.end() ? nullptr : &*found;
}

std::vector<DecodedSignal> decode_signals(const Message& message, const Frame& frame) {
  std::vector<DecodedSignal> result;
  if (frame.kind != FrameKind::data && frame.kind != FrameKind::fd) return result;
  Frame padded = frame;
  padded.length = 64;
  std::optional<std::int64_t> switched_to;
  for (const Signal& signal : message.signals)
    if (signal.multiplexing.is_switch) switched_to = SignalCodec(signal).unpack_raw(padded.payload());
  result.reserve(message.signals.size());
  for (const Signal& signal : message.signals) {
    const auto present_at = signal.multiplexing.present_at;
    if (present_at && switched_to != std::int64_t{*present_at}) continue;
    const unsigned end = signal.byte_order == ByteOrder::little_endian
                             ? signal.start_bit + 0U + signal.length
                             : 8U * (signal.start_bit / 8U) + 7U - signal.start_bit % 8U + signal.length;
    if (end > 8U * frame.length) continue;
    const SignalCodec codec(signal);
    DecodedSignal decoded{&signal, codec.unpack_raw(padded.payload()), codec.unpack(padded.payload()), {}};
    const auto name = signal.values.find(decoded.raw);
    if (name != signal.values.end()) decoded.name = name->second;
    result.push_back(decoded);
  }
  return result;
}

}  // namespace hystcan::can
