#include "can/protocol/emergency.h"

#include <algorithm>
#include <array>

namespace hystcan::can {
namespace {

struct Text {
  std::uint16_t code;
  std::string_view text;
};

constexpr std::array texts{
    Text{0x0000, "error reset, or no error"},
    Text{0x1000, "generic error"},
    Text{0x2000, "current"},
    Text{0x2100, "current, device input side"},
    Text{0x2200, "current inside the device"},
    Text{0x2300, "current, device output side"},
    Text{0x3000, "voltage"},
    Text{0x3100, "mains voltage"},
    Text{0x3200, "voltage inside the device"},
    Text{0x3300, "output voltage"},
    Text{0x4000, "temperature"},
    Text{0x4100, "ambient temperature"},
    Text{0x4200, "device temperature"},
    Text{0x5000, "device hardware"},
    Text{0x6000, "device software"},
    Text{0x6100, "internal software"},
    Text{0x6200, "user software"},
    Text{0x6300, "data set"},
    Text{0x7000, "additional modules"},
    Text{0x8000, "monitoring"},
    Text{0x8100, "communication"},
    Text{0x8110, "CAN overrun, objects lost"},
    Text{0x8120, "CAN in error-passive mode"},
    Text{0x8130, "life guard or heartbeat error"},
    Text{0x8140, "recovered from bus-off"},
    Text{0x8150, "CAN identifier collision"},
    Text{0x8200, "protocol error"},
    Text{0x8210, "PDO not processed, length error"},
    Text{0x8220, "PDO length exceeded"},
    Text{0x8230, "DAM MPDO not processed, destination object not available"},
    Text{0x8240, "unexpected SYNC data length"},
    Text{0x8250, "RPDO timeout"},
    Text{0x9000, "external error"},
    Text{0xF000, "additional functions"},
    Text{0xFF00, "device-specific"},
};

}  // namespace

std::string_view emergency_text(std::uint16_t code) {
  for (const unsigned mask : {0xFFFFU, 0xFF00U, 0xF000U}) {
    const unsigned group = code & mask;
    if (group == 0 && code != 0) continue;  // 0x0001 is not "no error"
    const auto found = std::ranges::find(texts, group, &Text::code);
    if (found != texts.end()) return found->text;
  }
  return "reserved error code";
}

}  // namespace hystcan::can
