// The configuration of a twin.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "can/protocol/protocol.h"
#include "model/coupling.h"
#include "node/config.h"
#include "twin/fault.h"
#include "twin/noise.h"
#include "twin/plant.h"
#include "twin/sensor.h"

namespace hystcan::twin {

struct AxisConfig : node::AmplifierConfig {
  Plant::Config plant;
  Sensor::Config sensor;
  std::vector<model::Coupling> couplings{};  ///< motion of other axes that also moves this axis (crosstalk)
  DriveNoise::Config drive_noise{};
  node::SampleClock sample_clock{};
};

struct WiredAxisConfig {
  can::AxisWire wire;
  AxisConfig axis;
};

/// The settings of the whole twin, common to all its axes.
struct CommonConfig : node::CommonConfig {
  std::uint64_t seed = 1;
  std::vector<FaultSpec> faults{};  ///< scheduled faults; their times count from Twin::start()
  std::optional<RandomFaults> random_faults{};
};

struct Config : CommonConfig {
  std::vector<WiredAxisConfig> axes;
};

/// Returns the configuration with only the axes in `names` and their faults; the removed axes are real or
/// belong to other twins. Throws std::invalid_argument if a name does not exist, or if a kept axis shares a
/// node with a removed one.
Config with_axes(Config config, const std::vector<std::string>& names);

}  // namespace hystcan::twin
