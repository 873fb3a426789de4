// The meaning of the error code of an emergency message (CiA 301, table of emergency error codes).
#pragma once

#include <cstdint>
#include <string_view>

namespace hystcan::can {

/// The text of the code or, if it has none, of its group: 0x2310 -> 0x2300 -> 0x2000. A code without a group
/// is reserved.
std::string_view emergency_text(std::uint16_t code);

}  // namespace hystcan::can
