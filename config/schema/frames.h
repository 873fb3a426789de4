// The frames of an axis: their messages, their protection, and the functions that are lost if a role of the
// lab's own frames has no signal.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "can/protocol/protocol.h"
#include "config/schema/config.h"

namespace hystcan::config {

/// Returns true for the roles without which control is impossible.
inline bool must_be_carried(std::string_view role) { return role == "setpoint" || role == "position"; }

/// Returns true if the amplifier's status reports both that it is enabled and that it has tripped.
bool reports_state(const can::AxisWire& axis);

/// Returns the functions that the controller lacks, one sentence each; empty for the standard frames.
std::vector<std::string> losses(const can::AxisWire& axis);

/// Returns the axis's messages in the database, standard or the lab's own.
std::vector<const can::Message*> messages_of(const can::AxisWire& axis, const can::Database& database);

/// Returns the names of the axis's messages that are CAN FD.
std::vector<std::string> fd_messages(const can::AxisWire& axis, const can::Database& database);
/// Returns the CAN FD messages of all axes, each once.
std::vector<std::string> fd_messages(const Config& config);

/// Returns a mask of the signal's bits in its message, by bytes.
std::vector<std::uint8_t> bits_of(const can::Message& message, const can::Signal& signal);

/// Returns the first axis with the same message `Payload` in [axis.frames] as axis i; i if there is none.
template <class Payload>
std::size_t first_sharing(const Config& config, std::size_t i) {
  const auto map = can::message_map<Payload>(config.axes[i].wire);
  for (std::size_t k = 0; k < i && map && config.axes[i].wire.frames; ++k)
    if (const can::AxisWire& other = config.axes[k].wire; other.frames)
      if (const auto theirs = can::message_map<Payload>(other); theirs && theirs->message == map->message)
        return k;
  return i;
}

/// Returns the protection (counter, CRC) of the axis's messages, standard or the lab's own.
can::Protections protections(const can::AxisWire& axis, const can::Database& database);

}  // namespace hystcan::config
