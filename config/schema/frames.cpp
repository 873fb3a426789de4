#include "config/schema/frames.h"

#include <fmt/format.h>

#include <utility>

namespace hystcan::config {
namespace {

/// The name of a role, and a sentence about the function that is lost if no signal has this role.
using Loss = std::pair<const char*, const char*>;

constexpr Loss command_losses[] = {
    {"enable",
     "no Enable: the first command switches the amplifier on, and the controller cannot switch it off; when "
     "the controller ends, the amplifier's watchdog trips"},
    {"clear_fault", "no ClearFault: --clear-faults has no effect; clear faults at the amplifier"},
    {"sync_counter", "no SyncCounter: the amplifier cannot distinguish a stale command from a fresh one"}};

constexpr Loss status_losses[] = {
    {"output",
     "no Output: the ramp-in starts at the safe drive instead of the amplifier's output, and the CSV shows "
     "the safe drive"},
    {"state", "no State: an amplifier that ignores Enable is not detected"},
    {"fault", "no Fault: a fault is shown by the State only, without its code"}};

constexpr Loss sample_losses[] = {
    {"sync_counter",
     "no SyncCounter: a sample counts for the cycle in which it arrives; a sample "
     "that is one cycle late counts as fresh"},
    {"status", "no Status: a sample that the sensor marks as bad is used"}};

void add(std::vector<std::string>& lines, const std::string& place, const can::MessageMap& map,
         std::span<const Loss> all) {
  for (const auto& [role, what] : all)
    if (!map.carries(role)) lines.push_back(place + what);
  if (map.integrity == can::Integrity::none)
    lines.push_back(place + "no counter: a repeated or frozen frame counts as fresh");
  if (map.integrity != can::Integrity::counter_crc)
    lines.push_back(place + "no CRC: damage to a frame outside the bus (in node or gateway) is not detected");
}

/// Returns the names of the messages of an axis and of their signals. The messages are command and sample
/// and, if they exist, amplifier status, controller status, setpoint and scan marker.
std::vector<can::MessageMap> maps_of(const can::AxisWire& axis, const can::Database& database) {
  std::vector<can::MessageMap> maps;
  for (auto& map :
       {can::message_map<can::AmpCommand>(axis), can::message_map<can::AmpStatus>(axis),
        can::message_map<can::SensorSample>(axis), can::message_map_in<can::ControllerStatus>(database, axis),
        can::message_map_in<can::Setpoint>(database, axis),
        can::message_map_in<can::ScanMarker>(database, axis)})
    if (map) maps.push_back(*map);
  return maps;
}

}  // namespace

bool reports_state(const can::AxisWire& axis) {
  const auto status = can::message_map<can::AmpStatus>(axis);
  return status && status->carries("state");
}

std::vector<std::string> losses(const can::AxisWire& axis) {
  std::vector<std::string> lines;
  if (!axis.frames) return lines;
  add(lines, "command: ", axis.frames->command, command_losses);
  if (axis.frames->status)
    add(lines, "status: ", *axis.frames->status, status_losses);
  else
    lines.emplace_back(
        "no status: the controller cannot read the amplifier back, so a trip or an ignored Enable appears "
        "only as a following error; the ramp-in starts at the safe drive, enable_delay_ms after Enable");
  add(lines, "sample: ", axis.frames->sample, sample_losses);
  return lines;
}

std::vector<const can::Message*> messages_of(const can::AxisWire& axis, const can::Database& database) {
  std::vector<const can::Message*> messages;
  for (const can::MessageMap& map : maps_of(axis, database))
    messages.push_back(&can::find_message(database, map));
  return messages;
}

std::vector<std::string> fd_messages(const can::AxisWire& axis, const can::Database& database) {
  std::vector<std::string> names;
  for (const can::Message* message : messages_of(axis, database))
    if (can::wire_kind(message->length, message->fd) == can::FrameKind::fd) names.push_back(message->name);
  return names;
}

std::vector<std::uint8_t> bits_of(const can::Message& message, const can::Signal& signal) {
  std::vector<std::uint8_t> bits(message.length);
  can::SignalCodec(signal).pack_raw(-1, bits);
  return bits;
}

std::vector<std::string> fd_messages(const Config& config) {
  std::vector<std::string> all;
  for (const AxisConfig& axis : config.axes)
    for (const std::string& name : fd_messages(axis.wire, config.database))
      if (std::ranges::find(all, name) == all.end()) all.push_back(name);
  return all;
}

can::Protections protections(const can::AxisWire& axis, const can::Database& database) {
  can::Protections found;
  for (const can::MessageMap& map : maps_of(axis, database)) {
    const can::Message& message = can::find_message(database, map);
    found.emplace(message.name, can::protection_of(message, map));
  }
  return found;
}

}  // namespace hystcan::config
