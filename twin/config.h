// What a twin is made of.
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
  std::vector<model::Coupling> couplings{};  ///< Of the way that the other axis is from its start.
  DriveNoise::Config drive_noise{};
  node::SampleClock sample_clock{};
};

struct WiredAxisConfig {
  can::AxisWire wire;
  AxisConfig axis;
};

/// What holds for the twin as a whole.
struct CommonConfig : node::CommonConfig {
  std::uint64_t seed = 1;
  std::vector<FaultSpec> faults{};  ///< their times count from start()
  std::optional<RandomFaults> random_faults{};
};

struct Config : CommonConfig {
  std::vector<WiredAxisConfig> axes;
};

/// The same twin with these axes alone and their faults; the others are other twins', or real. Throws
/// std::invalid_argument where there is no axis of a name.
Config with_axes(Config config, const std::vector<std::string>& names);

}  // namespace hystcan::twin
