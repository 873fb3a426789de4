// Decodes a frame with a DBC: finds its message and the value of every signal in the frame.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "can/dbc/database.h"
#include "can/frame.h"

namespace hystcan::can {

struct DecodedSignal {
  const Signal* signal = nullptr;  ///< points into the message that was given to decode_signals()
  std::int64_t raw = 0;            ///< raw value: an integer, or the bits of an IEEE 754 number
  double physical = 0.0;
  std::string_view name;  ///< name of the raw value (VAL_); empty if the value has no name
};

/// Finds the message with the identifier and the identifier type (11 or 29 bits) of this frame. Ignores the
/// length of the frame, and accepts a remote frame. Returns null for an error frame, or if the database has
/// no such message.
const Message* message_of(const Database& database, const Frame& frame);

/// Returns the signals that are present in this frame after simple and extended multiplexing (SG_MUL_VAL_),
/// in DBC order. Omits a signal if the payload is too short for the signal or if is_decodable() is false;
/// also omits all signals that depend on an omitted switch signal. A remote or error frame has no signals.
/// The value of a switch signal is read as an unsigned number.
std::vector<DecodedSignal> decode_signals(const Message& message, const Frame& frame);

}  // namespace hystcan::can
