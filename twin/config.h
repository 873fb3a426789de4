// What a twin is made of.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/protocol/protocol.h"
#include "model/coupling.h"
#include "twin/fault.h"
#include "twin/noise.h"
#include "twin/plant.h"
#include "twin/sensor_node.h"

namespace hystcan::twin {

/// Behaviour of the output after commands have stopped, until a command clears the fault.
enum class WatchdogAction : std::uint8_t {
  safe,  ///< goes to the safe value as fast as the amplifier can
  hold,  ///< stays at the last setpoint in force
  ramp,  ///< goes to the safe value at the amplifier's ramp
  off    ///< not driven: the load discharges to zero
};
constexpr auto words(WatchdogAction) {
  return std::to_array<std::string_view>({"safe", "hold", "ramp", "off"});
}

/// When a setpoint takes effect.
enum class Apply : std::uint8_t {
  sync,    ///< at the next SYNC (synchronous PDO, CiA 301): always one cycle after the SYNC that it answers
  receipt  ///< when its frame arrives: sooner, but the delay depends on the bus
};
constexpr auto words(Apply) { return std::to_array<std::string_view>({"sync", "receipt"}); }

struct AxisConfig {
  Plant::Config plant;
  Sensor::Config sensor;
  can::Duration command_timeout{};           ///< the amplifier trips when no command comes for this time
  unsigned status_every = 10;                ///< number of SYNCs per AmpStatus
  std::vector<model::Coupling> couplings{};  ///< Of the way that the other axis is from its start.
  WatchdogAction watchdog_action = WatchdogAction::safe;
  Apply apply = Apply::sync;
  bool interpolate = false;      ///< moves to a setpoint in a straight line within a cycle
  can::Duration enable_delay{};  ///< from Enable until the output is connected, by a relay
  /// From there the output goes evenly to its setpoint; only then it is enabled.
  can::Duration soft_start{};
  DriveNoise::Config drive_noise{};
  SampleClock sample_clock{};
};

struct WiredAxisConfig {
  can::AxisWire wire;
  AxisConfig axis;
};

/// What holds for the twin as a whole.
struct CommonConfig {
  std::uint64_t seed = 1;
  can::Duration heartbeat_period{};
  can::Duration cycle = std::chrono::milliseconds(1);  ///< of the SYNCs, as set in an amplifier
  unsigned background_slots = 0;                       ///< of heartbeats and statuses (can::is_in_slot)
  std::vector<FaultSpec> faults{};                     ///< their times count from start()
  std::optional<RandomFaults> random_faults{};
};

struct Config : CommonConfig {
  std::vector<WiredAxisConfig> axes;
};

/// The same twin with these axes alone and their faults; the others are other twins', or real. Throws
/// std::invalid_argument where there is no axis of a name.
Config with_axes(Config config, const std::vector<std::string>& names);

}  // namespace hystcan::twin
