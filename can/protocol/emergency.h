// What an emergency's error code means (CiA 301, table of emergency error codes).
#pragma once

#include <cstdint>
#include <string_view>

namespace hystcan::can {

/// The text of this very code, else of its group (0x2310 -> 0x2300 -> 0x2000); codes of no group are
/// reserved.
std::string_view emergency_text(std::uint16_t code);

}  // namespace hystcan::can
