// The devices that are connected to a card, as described in [axis.analogue].
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "can/protocol/protocol.h"
#include "node/analogue/card.h"
#include "node/config.h"

namespace hystcan::node {

enum class ActiveLevel : std::uint8_t { high, low };
constexpr auto words(ActiveLevel) { return std::to_array<std::string_view>({"high", "low"}); }

struct LineConfig {
  CardChannel place;
  ActiveLevel active = ActiveLevel::high;
};

struct InputConfig {
  CardChannel place;
  unsigned average = 1;  ///< number of conversions per sample
};

/// The devices of one axis. The drive in drive units and the position in um correspond to these voltages:
///
///   drive = volts / volts_per_drive,   position = position_zero_um + position_um_per_V * volts
struct AnalogueConfig {
  std::string device;  ///< name of the card (forms: see DeviceName)
  CardChannel drive_output;
  double volts_per_drive = 1.0;
  InputConfig position_input;
  double position_um_per_V = 1.0;
  double position_zero_um = 0.0;
  std::optional<CardChannel> output_input{};  ///< input that measures the amplifier's output; empty: the
                                              ///< output is assumed to equal the written value
  std::optional<LineConfig> enable_line{};
  std::optional<LineConfig> interlock_line{};  ///< while this input line is active, the amplifier has a fault
  std::optional<LineConfig> charge_pump_line{};  ///< output line that toggles at each SYNC; an external relay
                                                 ///< opens if the line stops toggling
  AmplifierConfig amplifier{.command_timeout = std::chrono::milliseconds(20)};

  double position_um(double volts) const { return position_zero_um + position_um_per_V * volts; }
};

/// Range in drive units; the node refuses a setpoint outside of the range.
struct DriveRange {
  double min = 0.0;
  double max = 0.0;
  double safe = 0.0;
};

struct Span {
  double lo = 0.0;
  double hi = 0.0;
};

/// Ranges of positions of one axis, in um.
struct PositionRange {
  Span limits{};    ///< range of the allowed positions, from position_min_um to position_max_um
  Span stroke{};    ///< range of the positions that the model predicts for the range of drives
  Span setpoint{};  ///< range of the setpoints in the configuration
};

struct WiredAnalogueAxis {
  can::AxisWire wire;
  AnalogueConfig config;
  DriveRange drives;
  PositionRange positions{};
};

}  // namespace hystcan::node
