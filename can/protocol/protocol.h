// The messages of the axes. The DBC gives their layout; the configuration may give their names.
// can/protocol/node.h has the CANopen frames and all identifiers. docs/protocol/frames.md has the table and
// one annotated frame.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "can/dbc/database.h"
#include "can/protocol/layout.h"
#include "can/protocol/node.h"
#include "can/protocol/sdo.h"

namespace hystcan::can {

/// Bits of AmpStatus.Fault.
namespace amp_fault {
inline constexpr std::uint8_t command_timeout = 0x01;
inline constexpr std::uint8_t setpoint_out_of_range = 0x02;
}  // namespace amp_fault

struct AmpCommand {
  static constexpr std::string_view name = "AmpCommand";
  double setpoint = 0.0;  ///< drive units
  bool enable = false;
  bool clear_fault = false;
  std::uint8_t sync_counter = 0;  ///< counter of the SYNC whose sample this command is computed from

  static constexpr auto fields() {
    return std::tuple{Field{"setpoint", "Setpoint", &AmpCommand::setpoint, Quantity::drive},
                      Field{"enable", "Enable", &AmpCommand::enable},
                      Field{"clear_fault", "ClearFault", &AmpCommand::clear_fault},
                      Field{"sync_counter", "SyncCounter", &AmpCommand::sync_counter}};
  }
};

struct AmpStatus {
  static constexpr std::string_view name = "AmpStatus";
  double output = 0.0;  ///< drive units, measured
  AmpState state = AmpState::off;
  std::uint8_t fault = 0;  ///< amp_fault bits

  static constexpr auto fields() {
    return std::tuple{Field{"output", "Output", &AmpStatus::output, Quantity::drive},
                      Field{"state", "State", &AmpStatus::state}, Field{"fault", "Fault", &AmpStatus::fault}};
  }
};

struct SensorSample {
  static constexpr std::string_view name = "SensorSample";
  double position_um = 0.0;
  std::uint8_t sync_counter = 0;  ///< counter of the SYNC at which the sensor took the sample
  std::uint8_t status = 0;        ///< 0: the sample is good

  static constexpr auto fields() {
    return std::tuple{Field{"position", "Position", &SensorSample::position_um, Quantity::position},
                      Field{"sync_counter", "SyncCounter", &SensorSample::sync_counter},
                      Field{"status", "Status", &SensorSample::status}};
  }
};

/// The controller's status of one axis. `state` and `cause` are the numbers of controller/control/axis.h; the
/// DBC has the same names for them.
struct ControllerStatus {
  static constexpr std::string_view name = "ControllerStatus";
  double following_error_um = 0.0;  ///< reference minus measured; 0 while the axis does not track
  std::uint8_t state = 0;           ///< controller::AxisState
  std::uint8_t cause = 0;           ///< controller::Cause
  bool in_position = false;
  bool limited = false;  ///< the command of this cycle differs from the demand of the control law
  bool reference_finished = false;

  static constexpr auto fields() {
    return std::tuple{
        Field{"following_error", "FollowingError", &ControllerStatus::following_error_um, Quantity::position},
        Field{"axis_state", "State", &ControllerStatus::state},
        Field{"cause", "Cause", &ControllerStatus::cause},
        Field{"in_position", "InPosition", &ControllerStatus::in_position},
        Field{"limited", "Limited", &ControllerStatus::limited},
        Field{"reference_finished", "ReferenceFinished", &ControllerStatus::reference_finished}};
  }
};

/// Values of Setpoint.Mode.
namespace setpoint_mode {
inline constexpr std::uint8_t follow = 0;  ///< follow the configured reference again
inline constexpr std::uint8_t go_to = 1;   ///< go to Position and stay there
}  // namespace setpoint_mode

/// A live setpoint. Any node may send it; the controller obeys it only if its configuration allows it.
struct Setpoint {
  static constexpr std::string_view name = "Setpoint";
  double position_um = 0.0;
  std::uint8_t mode = setpoint_mode::follow;

  static constexpr auto fields() {
    return std::tuple{Field{"position", "Position", &Setpoint::position_um, Quantity::position},
                      Field{"mode", "Mode", &Setpoint::mode}};
  }
};

/// Marks the start of a scan line on this axis. Both numbers count from 0.
struct ScanMarker {
  static constexpr std::string_view name = "ScanMarker";
  std::uint16_t line = 0;
  std::uint16_t frame = 0;
  std::uint8_t sync_counter = 0;  ///< counter of the SYNC of the first cycle of the line

  static constexpr auto fields() {
    return std::tuple{Field{"scan_line", "Line", &ScanMarker::line},
                      Field{"scan_frame", "Frame", &ScanMarker::frame},
                      Field{"sync_counter", "SyncCounter", &ScanMarker::sync_counter}};
  }
};

/// The controller's own messages. They always have their standard names, and a database may lack them.
template <class Payload>
inline constexpr bool is_optional = std::is_same_v<Payload, ControllerStatus> ||
                                    std::is_same_v<Payload, Setpoint> || std::is_same_v<Payload, ScanMarker>;

/// Names and nodes of one axis on the wire.
struct AxisWire {
  std::string name;            ///< "x"
  std::string message_prefix;  ///< "X": messages XAmpCommand, XAmpStatus, XSensorSample
  std::uint8_t amplifier_node = 0;
  std::uint8_t sensor_node = 0;
  std::string drive_unit{};  ///< unit of setpoint and output after conversion; empty: no conversion
  std::vector<SdoWrite> amplifier_setup{};  ///< written before the controller starts the node
  std::vector<SdoWrite> sensor_setup{};
  SdoPatience setup_patience{};
  std::optional<AxisFrames> frames{};  ///< the lab's own frames; empty: the standard frames
};

/// Returns the names of the message `Payload` of this axis; nullopt if the axis has no such message.
template <class Payload>
std::optional<MessageMap> message_map(const AxisWire& axis) {
  if constexpr (is_optional<Payload>) {
    if (axis.message_prefix.empty()) return std::nullopt;
    return standard_map<Payload>(axis.message_prefix);
  } else {
    if (!axis.frames) return standard_map<Payload>(axis.message_prefix);
    if constexpr (std::is_same_v<Payload, AmpCommand>)
      return axis.frames->command;
    else if constexpr (std::is_same_v<Payload, AmpStatus>)
      return axis.frames->status;
    else
      return axis.frames->sample;
  }
}

/// Finds the message. Throws std::invalid_argument if the database lacks it.
const Message& find_message(const Database& database, const MessageMap& map);

/// Like message_map(); also nullopt if the message is optional and the database lacks it.
template <class Payload>
std::optional<MessageMap> message_map_in(const Database& database, const AxisWire& axis) {
  auto map = message_map<Payload>(axis);
  if (is_optional<Payload> && map && database.find(map->message) == nullptr) return std::nullopt;
  return map;
}

/// Returns the compiled layout of the message `Payload` of this axis. A role that the message does not carry
/// gets its value from `absent`. nullopt under the same conditions as message_map_in(). Throws
/// std::invalid_argument if the database lacks a named message or signal.
template <class Payload>
std::optional<Layout<Payload>> find_layout(const Database& database, const AxisWire& axis,
                                           const Payload& absent = {}) {
  const auto map = message_map_in<Payload>(database, axis);
  if (!map) return std::nullopt;
  return Layout<Payload>(find_message(database, *map), *map, axis.drive_unit, absent);
}

}  // namespace hystcan::can
