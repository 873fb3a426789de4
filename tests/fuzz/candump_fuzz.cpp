// For any bytes, CandumpReader either refuses them with their place, or returns frames that are the same when
// they are written and read again.
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <string_view>

#include "can/log/candump.h"
#include "can/log/error_frame.h"
#include "tests/fuzz/demand.h"

namespace {

using namespace hystcan::can;
using hystcan::fuzz::demand;

void use(const LoggedFrame& logged) {
  demand(logged.frame.length <= (logged.frame.kind == FrameKind::fd ? 64 : 8));
  demand(logged.time.count() >= 0);
  std::istringstream again(candump_line(logged));
  const auto back = CandumpReader(again, "again").next();
  demand(back == logged);
  if (logged.frame.kind == FrameKind::error) demand(!describe_error(logged.frame).empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream stream(std::string(data, data + size));
  CandumpReader reader(stream, "fuzz.log");
  try {
    while (const auto logged = reader.next()) use(*logged);
  } catch (const hystcan::Error& error) {
    const std::string_view what = error.what();
    demand(what.starts_with("fuzz.log:" + std::to_string(reader.line()) + ':'));
    demand(what.find(": found ") != std::string_view::npos);
    demand(what.find(", expected ") != std::string_view::npos);
    demand(what.find('\n') == std::string_view::npos);
  }
  return 0;
}
