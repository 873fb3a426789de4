// Builds configurations that send the same axes in different kinds of CAN frames, to compare the bus load.
#pragma once

#include <cstddef>
#include <cstdint>

#include "config/schema/config.h"

namespace hystcan::config {

/// The kind of CAN frames that carry the data of the axes.
enum class Wiring : std::uint8_t {
  classical,  ///< each axis has its own standard frames of 8 bytes and two nodes; classical CAN
  fd,         ///< each axis has its own frames of 8 bytes and two nodes; CAN FD with bit-rate switch
  fd_shared,  ///< all axes share three CAN FD frames (samples, commands, statuses) and two nodes
  fd_slots    ///< as fd_shared, but a node sends heartbeats and statuses only in its slot, once in 24 cycles
};

/// Returns a configuration with `axes` copies of the first axis on one bus. The bus has only samples,
/// commands, amplifier statuses, controller statuses and heartbeats. A frame that n axes share has 4 + 3 n
/// bytes: a SYNC counter, a counter, a CRC-16, and 24 bits for each axis. The 24 bits are the position in a
/// sample; setpoint and flags in a command; output, state and fault in a status. If the bus has no data bit
/// rate, CAN FD uses 5 Mbit/s, or the bit rate if that is higher.
Config wired_as(Wiring wiring, std::size_t axes, const Config& config);

}  // namespace hystcan::config
