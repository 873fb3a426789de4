// Puts axes into frames of several kinds, to compare the bus load.
#pragma once

#include <cstddef>
#include <cstdint>

#include "config/schema/config.h"

namespace hystcan::config {

/// How axes are put into frames.
enum class Wiring : std::uint8_t {
  classical,  ///< the standard frames of 8 bytes; two nodes for each axis
  fd,         ///< like `classical`, as CAN FD with bit-rate switch
  fd_shared,  ///< all axes share three frames: samples, commands, statuses; one sensor and one amplifier
  fd_slots    ///< like `fd_shared`; the three nodes of the bus have slots eight cycles apart
};

/// Returns a configuration with `axes` copies of the first axis on the same bus and nothing else: samples,
/// commands, statuses, axis statuses, heartbeats. A frame that n axes share has 4 + 3 n bytes: SYNC counter,
/// counter, CRC-16, and, for each axis, 24 bits of position; of setpoint and flags; or of output, state and
/// fault. If the bus has no data bit rate, CAN FD uses 5 Mbit/s.
Config wired_as(Wiring wiring, std::size_t axes, const Config& config);

}  // namespace hystcan::config
