// The input is a DBC, a byte 0, then the bytes of a frame; without a byte 0 the whole input is both the DBC
// and the frame. Every message of the DBC is decoded from these bytes, and its signals are encoded again.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "can/dbc/database.h"
#include "can/dbc/message_decoder.h"
#include "can/dbc/signal_codec.h"
#include "tests/fuzz/demand.h"

namespace {

using namespace hystcan::can;
using hystcan::fuzz::demand;

/// Returns true if a double distinguishes neighbouring physical values of this signal, with a margin for
/// rounding.
bool is_exact(const Signal& signal) {
  if (signal.value_type != ValueType::integer || signal.scale == 0.0 || signal.length > 48) return false;
  const double scale = std::abs(signal.scale);
  const double span = std::ldexp(scale, signal.length);
  return scale >= std::numeric_limits<double>::min() && std::isfinite(span) &&
         std::abs(signal.offset) <= span;
}

void encode_again(const DecodedSignal& decoded, const Frame& frame) {
  const Signal& signal = *decoded.signal;
  const SignalCodec codec(signal);
  Frame again = frame;
  codec.pack_raw(decoded.raw, again.payload());
  demand(again == frame);
  const bool packed = codec.pack(decoded.physical, again.payload());
  demand(packed || again == frame);
  if (!is_exact(signal)) return;
  const bool stated = signal.minimum != 0.0 || signal.maximum != 0.0;
  demand(packed || stated);
  if (packed && !stated) demand(codec.unpack_raw(again.payload()) == decoded.raw);
}

void decode(const Database& database, const Message& message, std::span<const std::uint8_t> bytes) {
  Frame frame;
  frame.id = message.id;
  frame.extended = message.extended;
  frame.length = static_cast<std::uint8_t>(std::min(bytes.size(), frame.data.size()));
  frame.kind = frame.length > 8 ? FrameKind::fd : FrameKind::data;
  std::copy_n(bytes.begin(), frame.length, frame.data.begin());
  const Message* const found = message_of(database, frame);
  demand(found != nullptr && found->id == message.id && found->extended == message.extended);
  for (const DecodedSignal& decoded : decode_signals(message, frame)) encode_again(decoded, frame);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::uint8_t* const end = data + size;
  const std::uint8_t* const text_end = std::find(data, end, std::uint8_t{0});
  const std::span<const std::uint8_t> bytes =
      text_end == end ? std::span(data, size) : std::span(text_end + 1, end);
  try {
    const Database database = parse_dbc(
        {reinterpret_cast<const char*>(data), static_cast<std::size_t>(text_end - data)}, "fuzz.dbc");
    for (const Message& message : database.messages) decode(database, message, bytes);
  } catch (const hystcan::Error&) {
    return 0;
  }
  return 0;
}
