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
  std::vector<model::Coupling> couplings{};  ///< crosstalk of the motion of other axes since their start
  DriveNoise::Config drive_noise{};
  node::SampleClock sample_clock{};
};

struct WiredAxisConfig {
  can::AxisWire wire;
  AxisConfig axis;
};

/// The keys of the twin as a whole.
struct CommonConfig : node::CommonConfig {
  std::uint64_t seed = 1;
  std::vector<FaultSpec> faults{};  ///< fault times count from start()
  std::optional<RandomFaults> random_faults{};
};

struct Config : CommonConfig {
  std::vector<WiredAxisConfig> axes;
};

/// Returns the configuration with only these axes and their faults; the other axes are real or belong to
/// other twins. Throws std::invalid_argument if an axis name does not exist.
Config with_axes(Config config, const std::vector<std::string>& names);

}  // namespace hystcan::twin
