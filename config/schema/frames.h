// The CAN frames of an axis: their messages and their protection (counter, CRC). An axis has the standard
// frames or the lab's own frames. Each signal has a role, such as "enable". If the lab's own frames have no
// signal for a role, the controller lacks a function: without "enable", it cannot switch the amplifier off.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "can/protocol/protocol.h"
#include "config/schema/config.h"

namespace hystcan::config {

/// Returns true for a role that the frames must have, because control is impossible without it.
inline bool must_be_carried(std::string_view role) { return role == "setpoint" || role == "position"; }

/// Returns true if the amplifier has a status message with a signal for the role `state`. This signal reports
/// whether the amplifier is off, ready, enabled or in fault.
bool reports_state(const can::AxisWire& axis);

/// Returns a sentence for each function that is lost because the axis's frames lack a signal. The result is
/// empty for the standard frames.
std::vector<std::string> losses(const can::AxisWire& axis);

/// Returns the messages of the axis in the database, which are the standard messages or the lab's own.
std::vector<const can::Message*> messages_of(const can::AxisWire& axis, const can::Database& database);

/// Returns the names of those messages of the axis that are sent as CAN FD.
std::vector<std::string> fd_messages(const can::AxisWire& axis, const can::Database& database);
/// Returns the names of the CAN FD messages of all axes, each name once.
std::vector<std::string> fd_messages(const Config& config);

/// Returns the bits that the signal occupies in its message, as a mask for each byte.
std::vector<std::uint8_t> bits_of(const can::Message& message, const can::Signal& signal);

/// Returns the index of the first axis that shares the message `Payload` with axis `i`. Returns `i` if no
/// earlier axis shares it. Only axes with their own frames ([axis.frames]) can share a message.
template <class Payload>
std::size_t first_sharing(const Config& config, std::size_t i) {
  const auto map = can::message_map<Payload>(config.axes[i].wire);
  for (std::size_t k = 0; k < i && map && config.axes[i].wire.frames; ++k)
    if (const can::AxisWire& other = config.axes[k].wire; other.frames)
      if (const auto theirs = can::message_map<Payload>(other); theirs && theirs->message == map->message)
        return k;
  return i;
}

/// Returns the protection (counter, CRC) of each message of the axis, by the name of the message.
can::Protections protections(const can::AxisWire& axis, const can::Database& database);

}  // namespace hystcan::config
