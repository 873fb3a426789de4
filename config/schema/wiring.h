// Axes in frames of one kind or another, to compare what a bus carries.
#pragma once

#include <cstddef>
#include <cstdint>

#include "config/schema/config.h"

namespace hystcan::config {

/// How axes are put into frames.
enum class Wiring : std::uint8_t {
  classical,  ///< the standard frames of 8 bytes, of two nodes for each axis
  fd,         ///< the same as CAN FD with bit-rate switch
  fd_shared,  ///< one frame of all axes for samples, commands and statuses, of one sensor and one amplifier
  fd_slots    ///< the same, and the three nodes of the bus have slots, eight cycles apart
};

/// So many axes like the first one, on the same bus with nothing else on it: samples, commands, statuses,
/// axis statuses, heartbeats. A frame that n axes share has 4 + 3 n bytes: SYNC counter, counter, CRC-16, and
/// for each axis 24 bits of position, of setpoint and flags, or of output, state and fault. CAN FD without a
/// data bit rate has 5 Mbit/s.
Config wired_as(Wiring wiring, std::size_t axes, const Config& config);

}  // namespace hystcan::config
