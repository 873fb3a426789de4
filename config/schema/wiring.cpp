#include "config/schema/wiring.h"

#include <fmt/format.h>

#include <algorithm>

#include "can/protocol/protocol.h"

namespace hystcan::config {
namespace {

constexpr std::uint32_t usual_data_bitrate_bit_per_s = 5'000'000;

void add_message(can::Database& database, const can::MessageMap& map, std::uint32_t id, std::size_t length,
                 bool fd) {
  can::Message& message = database.messages.emplace_back();
  message.name = map.message;
  message.id = id;
  message.length = static_cast<std::uint16_t>(length);
  message.fd = fd;
  message.bit_rate_switch = fd;
}

/// Replaces the standard messages of an axis by messages that all axes share. The call for the first axis
/// also adds the shared messages to the database.
void share_messages(Config& config, can::AxisWire& wire, std::size_t axes) {
  wire.frames = can::AxisFrames{.command = {.message = "AmpCommand"},
                                .status = can::MessageMap{.message = "AmpStatus"},
                                .sample = {.message = "SensorSample"}};
  if (!config.database.messages.empty()) return;
  const std::size_t length = 4 + 3 * axes;
  add_message(config.database, wire.frames->command, can::receive_pdo_base + wire.amplifier_node, length,
              true);
  add_message(config.database, *wire.frames->status, can::transmit_pdo_base + wire.amplifier_node, length,
              true);
  add_message(config.database, wire.frames->sample, can::transmit_pdo_base + wire.sensor_node, length, true);
}

void add_standard_messages(can::Database& database, const can::AxisWire& wire, bool fd) {
  const std::string& prefix = wire.message_prefix;
  const auto add = [&]<class Payload>(std::uint32_t id) {
    add_message(database, can::standard_map<Payload>(prefix), id, 8, fd);
  };
  add.template operator()<can::AmpCommand>(can::receive_pdo_base + wire.amplifier_node);
  add.template operator()<can::AmpStatus>(can::transmit_pdo_base + wire.amplifier_node);
  add.template operator()<can::SensorSample>(can::transmit_pdo_base + wire.sensor_node);
}

}  // namespace

Config wired_as(Wiring wiring, std::size_t axes, const Config& config) {
  Config wired = config;
  wired.axes.assign(axes, config.axes.front());
  wired.database = {};
  if (wiring != Wiring::classical && wired.bus.data_bitrate_bit_per_s == 0)
    wired.bus.data_bitrate_bit_per_s = std::max(usual_data_bitrate_bit_per_s, wired.bus.bitrate_bit_per_s);
  const bool shares = wiring == Wiring::fd_shared || wiring == Wiring::fd_slots;
  constexpr unsigned slots = 24;
  if (wiring == Wiring::fd_slots) {
    wired.bus.background_slots = slots;
    wired.controller.node = slots;
  }
  // The number of a node's slot is its id modulo `slots`. So the ids of amplifier, sensor and controller have
  // equal distances: this spreads their three slots evenly over the round of slots.
  const std::size_t slot_spacing = wiring == Wiring::fd_slots ? slots / 3 : 1;
  // Returns the id of a node. `place` is the index of the node. The ids omit the id of the controller.
  const auto node = [&](std::size_t place) {
    const std::size_t number = slot_spacing * (place + 1);
    return static_cast<std::uint8_t>(number < wired.controller.node ? number : number + 1);
  };
  for (std::size_t i = 0; i < axes; ++i) {
    AxisConfig& axis = wired.axes[i];
    axis.live_setpoint = false;
    axis.scan_marker = false;
    const std::size_t first = shares ? 0 : 2 * i;
    axis.wire = can::AxisWire{.name = fmt::format("axis {}", i),
                              .message_prefix = fmt::format("Axis{}", i),
                              .amplifier_node = node(first),
                              .sensor_node = node(first + 1)};
    if (shares)
      share_messages(wired, axis.wire, axes);
    else
      add_standard_messages(wired.database, axis.wire, wiring == Wiring::fd);
    add_message(wired.database, can::standard_map<can::ControllerStatus>(axis.wire.message_prefix),
                can::controller_status_base + static_cast<std::uint32_t>(i) + 1, 8,
                wiring != Wiring::classical);
  }
  return wired;
}

}  // namespace hystcan::config
