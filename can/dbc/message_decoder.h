// Decodes a frame by the DBC: every signal that it carries, with unit and name.
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
  std::string_view name;  ///< name of the raw value (VAL_); empty if it has none
};

/// The message with the identifier and the identifier type of this frame. The length of the frame does not
/// matter, and it may be a remote frame. Null if the database has no such message, and for error frames.
const Message* message_of(const Database& database, const Frame& frame);

/// The signals that are present after simple and extended multiplexing (SG_MUL_VAL_), in DBC order.
/// A signal is left out if the payload is too short for it or if it is not decodable; the signals that it
/// switches are left out, too. A remote or error frame has no signals. The value of a switch is its bits as
/// an unsigned number.
std::vector<DecodedSignal> decode_signals(const Message& message, const Frame& frame);

}  // namespace hystcan::can
