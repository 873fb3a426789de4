// For any bytes, parse_dbc either refuses them with their place, or returns a database in which every
// signal can be used.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "can/dbc/database.h"
#include "can/dbc/signal_codec.h"
#include "tests/fuzz/demand.h"

namespace {

using namespace hystcan::can;
using hystcan::fuzz::demand;

void use(const Signal& signal) {
  if (!is_decodable(signal)) return;  // the database keeps it, but it is not decoded
  const SignalCodec codec(signal);
  std::vector<std::uint8_t> payload(bytes_needed(signal), 0xA5);
  const std::vector<std::uint8_t> before = payload;

  codec.pack_raw(codec.unpack_raw(payload), payload);
  demand(payload == before);
  const double physical = codec.unpack(payload);
  const bool packed = codec.pack(physical, payload);
  demand(packed || payload == before);
  demand(codec.pack(codec.minimum(), payload) || codec.minimum() > codec.maximum() || signal.length > 32 ||
         signal.value_type != ValueType::integer || signal.offset != 0.0 || signal.scale == 0.0 ||
         !std::isfinite(codec.minimum()));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + size);
  try {
    const Database database = parse_dbc(text, "fuzz.dbc");
    for (const Message& message : database.messages) {
      demand(database.find(message.name) != nullptr);
      for (const Signal& signal : message.signals) use(signal);
    }
    for (const std::string& warning : database.warnings) demand(warning.starts_with("fuzz.dbc:"));
  } catch (const hystcan::Error& error) {
    const std::string_view what = error.what();
    demand(what.starts_with("fuzz.dbc:"));
    demand(what.find(": found ") != std::string_view::npos &&
           what.find(", expected ") != std::string_view::npos);
  }
  return 0;
}
