#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "can/sdo.h"

namespace hystcan::can {
namespace {

struct Text {
  std::uint32_t code;
  std::string_view text;
};

// CiA 301, table of SDO abort codes.
constexpr std::array texts{
    Text{0x0503'0000, "toggle bit not alternated"},
    Text{0x0504'0000, "SDO protocol timed out"},
    Text{0x0504'0001, "command specifier not valid or unknown"},
    Text{0x0504'0002, "invalid block size"},
    Text{0x0504'0003, "invalid sequence number"},
    Text{0x0504'0004, "CRC error"},
    Text{0x0504'0005, "out of memory"},
    Text{0x0601'0000, "unsupported access to an object"},
    Text{0x0601'0001, "attempt to read a write-only object"},
    Text{0x0601'0002, "attempt to write a read-only object"},
    Text{0x0602'0000, "object does not exist in the object dictionary"},
    Text{0x0604'0041, "object cannot be mapped to the PDO"},
    Text{0x0604'0042, "the mapped objects would exceed the PDO's length"},
    Text{0x0604'0043, "general parameter incompatibility"},
    Text{0x0604'0047, "general internal incompatibility in the device"},
    Text{0x0606'0000, "access failed due to a hardware error"},
    Text{0x0607'0010, "data type or length does not match"},
    Text{0x0607'0012, "data type does not match, too long"},
    Text{0x0607'0013, "data type does not match, too short"},
    Text{0x0609'0011, "sub-index does not exist"},
    Text{0x0609'0030, "invalid value for the parameter"},
    Text{0x0609'0031, "value of the parameter too high"},
    Text{0x0609'0032, "value of the parameter too low"},
    Text{0x0609'0036, "maximum value is less than minimum value"},
    Text{0x060A'0023, "resource not available: SDO connection"},
    Text{0x0800'0000, "general error"},
    Text{0x0800'0020, "data cannot be transferred or stored"},
    Text{0x0800'0021, "data cannot be transferred or stored because of local control"},
    Text{0x0800'0022, "data cannot be transferred or stored in the present device state"},
    Text{0x0800'0023, "no object dictionary present, or it could not be generated"},
    Text{0x0800'0024, "no data available"},
};

}  // namespace

std::string_view sdo_abort_text(std::uint32_t code) {
  const auto found = std::ranges::find(texts, code, &Text::code);
  return found == texts.end() ? "unknown abort code" : found->text;
}

std::string describe(const SdoFailure& failure) {
  const std::string object =
      fmt::format("object 0x{:04X}:{:02X}: ", failure.object.index, failure.object.subindex);
  switch (failure.reason) {
    case SdoFailure::Reason::timed_out:
      return object + "the node does not answer";
    case SdoFailure::Reason::aborted:
      return object + fmt::format("refused by the node with 0x{:08X}: {}", failure.abort_code,
                                  sdo_abort_text(failure.abort_code));
    case SdoFailure::Reason::read_back_differs:
      return object +
             fmt::format("0x{:X} was written, 0x{:X} was read back", failure.written, failure.read_back);
    case SdoFailure::Reason::none:
      break;
  }
  return object + "no failure";
}

}  // namespace hystcan::can
