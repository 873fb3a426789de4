// What is known of a stage before the program has measured it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "can/protocol/layout.h"
#include "model/reference_curve.h"

namespace hystcan::app {

struct AxisFacts {
  std::string name;
  std::string drive_unit;                   ///< V or A
  double drive_min = 0.0, drive_max = 0.0;  ///< drive units
  double safe_drive = 0.0;                  ///< where every run ends
  model::Interval travel_um{};              ///< positions at the ends of the range of the drive
  double resonance_Hz = 0.0;
  double damping_ratio = 0.0;
  double sensor_delay_us = 0.0;     ///< from the position to its sample; 0: none, or not known
  bool mode_is_measured = false;    ///< resonance and damping are those of a step
  bool damping_is_assumed = false;  ///< nobody stated or measured it
  double noise_um = 0.0;            ///< of the sensor, rms
  std::uint8_t amplifier_node = 1, sensor_node = 2;
  std::string message_prefix{};             ///< of the standard frames; empty: `frames`
  std::optional<can::AxisFrames> frames{};  ///< the lab's own
  std::string model_file, plant_file;       ///< names of the controller's model and of the twin's
};

struct StageFacts {
  std::string interface;
  std::uint32_t bitrate_bit_per_s = 1'000'000;
  double rate_Hz = 1000.0;
  std::string dbc;  ///< name of the file, beside the configuration
  std::vector<AxisFacts> axes;
};

}  // namespace hystcan::app
