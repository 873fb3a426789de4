#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "can/protocol/sdo.h"

namespace hystcan::can {
namespace {

struct AbortText {
  std::uint32_t code;
  std::string_view text;
};

// CiA 301, table of SDO abort codes.
constexpr std::array abort_texts{
    AbortText{0x0503'0000, "toggle bit not alternated"},
    AbortText{0x0504'0000, "SDO protocol timed out"},
    AbortText{0x0504'0001, "command specifier not valid or unknown"},
    AbortText{0x0504'0002, "invalid block size"},
    AbortText{0x0504'0003, "invalid sequence number"},
    AbortText{0x0504'0004, "CRC error"},
    AbortText{0x0504'0005, "out of memory"},
    AbortText{0x0601'0000, "unsupported access to an object"},
    AbortText{0x0601'0001, "attempt to read a write-only object"},
    AbortText{0x0601'0002, "attempt to write a read-only object"},
    AbortText{0x0602'0000, "object does not exist in the object dictionary"},
    AbortText{0x0604'0041, "object cannot be mapped to the PDO"},
    AbortText{0x0604'0042, "the mapped objects would exceed the PDO's length"},
    AbortText{0x0604'0043, "general parameter incompatibility"},
    AbortText{0x0604'0047, "general internal incompatibility in the device"},
    AbortText{0x0606'0000, "access failed due to a hardware error"},
    AbortText{0x0607'0010, "data type or length does not match"},
    AbortText{0x0607'0012, "data type does not match, too long"},
    AbortText{0x0607'0013, "data type does not match, too short"},
    AbortText{0x0609'0011, "sub-index does not exist"},
    AbortText{0x0609'0030, "invalid value for the parameter"},
    AbortText{0x0609'0031, "value of the parameter too high"},
    AbortText{0x0609'0032, "value of the parameter too low"},
    AbortText{0x0609'0036, "maximum value is less than minimum value"},
    AbortText{0x060A'0023, "resource not available: SDO connection"},
    AbortText{0x0800'0000, "general error"},
    AbortText{0x0800'0020, "data cannot be transferred or stored"},
    AbortText{0x0800'0021, "data cannot be transferred or stored because of local control"},
    AbortText{0x0800'0022, "data cannot be transferred or stored in the present device state"},
    AbortText{0x0800'0023, "no object dictionary present, or it could not be generated"},
    AbortText{0x0800'0024, "no data available"},
};

}  // namespace

std::string_view sdo_abort_text(std::uint32_t code) {
  const auto found = std::ranges::find(abort_texts, code, &AbortText::code);
  return found == abort_texts.end() ? "unknown abort code" : found->text;
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
    case SdoFailure::Reason::segmented:
      return object + "the node answers in segments, expected a value of at most 4 bytes";
    case SdoFailure::Reason::none:
      break;
  }
  return object + "no failure";
}

}  // namespace hystcan::can
