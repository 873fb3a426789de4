// The values in the messages of the axes. The DBC defines the layout of these messages; the configuration may
// define their names. can/protocol/node.h has the CANopen frames and all identifiers. docs/protocol/frames.md
// has a table of the messages and one annotated frame.
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

/// Bits of the signal Fault in the message AmpStatus.
namespace amp_fault {
inline constexpr std::uint8_t command_timeout = 0x01;
inline constexpr std::uint8_t setpoint_out_of_range = 0x02;
}  // namespace amp_fault

struct AmpCommand {
  static constexpr std::string_view name = "AmpCommand";
  double setpoint = 0.0;  ///< commanded drive in its unit, such as V or A
  bool enable = false;
  bool clear_fault = false;
  std::uint8_t sync_counter = 0;  ///< counter of the SYNC at which the sample for this command was taken

  static constexpr auto fields() {
    return std::tuple{Field{"setpoint", "Setpoint", &AmpCommand::setpoint, Quantity::drive},
                      Field{"enable", "Enable", &AmpCommand::enable},
                      Field{"clear_fault", "ClearFault", &AmpCommand::clear_fault},
                      Field{"sync_counter", "SyncCounter", &AmpCommand::sync_counter}};
  }
};

struct AmpStatus {
  static constexpr std::string_view name = "AmpStatus";
  double output = 0.0;  ///< measured output, in the unit of the drive, such as V or A
  AmpState state = AmpState::off;
  std::uint8_t fault = 0;  ///< bits of the namespace amp_fault

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

/// The status of one axis in the controller. `state` and `cause` have the numbers of the enumerators in
/// controller/control (axis_report.h, fault.h); the DBC gives these numbers the same names.
struct ControllerStatus {
  static constexpr std::string_view name = "ControllerStatus";
  double following_error_um = 0.0;  ///< reference minus measured position; 0 while the axis does not track
  std::uint8_t state = 0;           ///< number of an enumerator of controller::AxisState
  std::uint8_t cause = 0;           ///< number of an enumerator of controller::Cause
  bool in_position = false;
  bool limited = false;  ///< the command of this cycle differs from the output of the control law
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

/// Values of the signal Mode in the message Setpoint.
namespace setpoint_mode {
inline constexpr std::uint8_t follow = 0;  ///< follow the configured reference again
inline constexpr std::uint8_t go_to = 1;   ///< go to the position in the message and stay there
}  // namespace setpoint_mode

/// A live setpoint: a target position during the run. Any node may send this message; the controller obeys
/// the message only if the configuration allows live setpoints.
struct Setpoint {
  static constexpr std::string_view name = "Setpoint";
  double position_um = 0.0;
  std::uint8_t mode = setpoint_mode::follow;

  static constexpr auto fields() {
    return std::tuple{Field{"position", "Position", &Setpoint::position_um, Quantity::position},
                      Field{"mode", "Mode", &Setpoint::mode}};
  }
};

/// Marks the start of a scan line on this axis. `line` and `frame` count lines and images from 0.
struct ScanMarker {
  static constexpr std::string_view name = "ScanMarker";
  std::uint16_t line = 0;
  std::uint16_t frame = 0;
  std::uint8_t sync_counter = 0;  ///< counter of the SYNC at which this scan line begins

  static constexpr auto fields() {
    return std::tuple{Field{"scan_line", "Line", &ScanMarker::line},
                      Field{"scan_frame", "Frame", &ScanMarker::frame},
                      Field{"sync_counter", "SyncCounter", &ScanMarker::sync_counter}};
  }
};

/// True for the messages of the controller itself. These messages always have their standard names, and the
/// user's DBC need not contain them.
template <class Payload>
inline constexpr bool is_optional = std::is_same_v<Payload, ControllerStatus> ||
                                    std::is_same_v<Payload, Setpoint> || std::is_same_v<Payload, ScanMarker>;

/// Names and nodes of one axis on the wire.
struct AxisWire {
  std::string name;            ///< name of the axis, such as "x"
  std::string message_prefix;  ///< prefix of message names: "X" for XAmpCommand and XSensorSample
  std::uint8_t amplifier_node = 0;
  std::uint8_t sensor_node = 0;
  std::string drive_unit{};  ///< unit of the commanded drive and the measured output in this program, such as
                             ///< V; empty: the unit of the DBC
  std::vector<SdoWrite> amplifier_setup{};  ///< SDO objects to write before the controller starts the node
  std::vector<SdoWrite> sensor_setup{};
  SdoPatience setup_patience{};
  std::optional<AxisFrames> frames{};  ///< frames that the user defines; empty: the standard frames
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

/// Finds the message with the name map.message. Throws std::invalid_argument if the database has no such
/// message.
const Message& find_message(const Database& database, const MessageMap& map);

/// Returns the names of the message `Payload` of this axis. Returns nullopt if message_map() does, or if the
/// message is optional (is_optional<Payload>) and the database does not contain it.
template <class Payload>
std::optional<MessageMap> message_map_in(const Database& database, const AxisWire& axis) {
  auto map = message_map<Payload>(axis);
  if (is_optional<Payload> && map && database.find(map->message) == nullptr) return std::nullopt;
  return map;
}

/// Returns the layout of the message `Payload` of this axis; nullopt if message_map_in() returns nullopt. A
/// value for which the message has no signal is decoded as the value in `absent`. Throws
/// std::invalid_argument if the database does not contain the message or one of its configured signals.
template <class Payload>
std::optional<Layout<Payload>> find_layout(const Database& database, const AxisWire& axis,
                                           const Payload& absent = {}) {
  const auto map = message_map_in<Payload>(database, axis);
  if (!map) return std::nullopt;
  return Layout<Payload>(find_message(database, *map), *map, axis.drive_unit, absent);
}

}  // namespace hystcan::can
