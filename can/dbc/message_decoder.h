// Decodes a frame by the DBC: every signal in the frame, with its unit and name.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "can/dbc/database.h"
#include "can/frame.h"

namespace hystcan::can {

struct DecodedSignal {
  const Signal* signal = nullptr;  ///< a signal of the given message
  std::int64_t raw = 0;            ///< the integer, or the bits of an IEEE 754 number
  double physical = 0.0;
  std::string_view name;  ///< name of the raw value (VAL_); empty if the value has no name
};

/// Finds the message with the identifier and the identifier type of this frame. The length of the frame does
/// not matter, and a remote frame is allowed. Null for error frames, and if the database has no such message.
const Message* message_of(const Database& database, const Frame& frame);

/// Returns the signals that are present after simple and extended multiplexing (SG_MUL_VAL_), in DBC order.
/// Omits a signal if the payload is too short for it or if it is not decodable; also omits the signals that
/// an omitted signal switches. A remote or error frame has no signals. The value of a switch is read
/// as an unsigned number.
std::vector<DecodedSignal> decode_signals(const Message& message, const Frame& frame);

}  // namespace hystcan::can
