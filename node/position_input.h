// The input of a sensor node: a simulated sensor, or an analogue-digital converter behind a real sensor.
#pragma once

#include <cstdint>

#include "can/scheduler.h"

namespace hystcan::node {

/// Bits of the signal Status in the message SensorSample.
namespace sensor_status {
inline constexpr std::uint8_t out_of_range = 0x01;  ///< the reading is saturated
inline constexpr std::uint8_t no_position = 0x02;   ///< the sample has no position: the conversion failed, or
                                                    ///< the reading is at an end of the input range
}  // namespace sensor_status

class PositionInput {
 public:
  struct Reading {
    double position_um = 0.0;
    std::uint8_t status = 0;  ///< bits of the namespace sensor_status; 0: the reading is good
  };

  PositionInput() = default;
  PositionInput(const PositionInput&) = delete;
  PositionInput& operator=(const PositionInput&) = delete;
  virtual ~PositionInput() = default;

  virtual Reading read(can::Time at) = 0;
};

}  // namespace hystcan::node
