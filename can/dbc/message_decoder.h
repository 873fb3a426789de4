// What a frame says by the DBC: every signal that it carries, with unit and name.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "can/dbc/database.h"
#include "can/frame.h"

namespace hystcan::can {

struct DecodedSignal {
  const Signal* signal = nullptr;  ///< of the message decoded with
  std::int64_t raw = 0;            ///< the bits; those of a float signal as they stand
  double physical = 0.0;
  std::string_view name;  ///< of the raw value (VAL_), empty where it has none
};

/// The message of this frame by identifier and its type, data or remote, whatever its length. Null where the
/// database has none, and for error frames.
const Message* message_of(const Database& database, const Frame& frame);

/// The signals present, multiplexing resolved (also extended, SG_MUL_VAL_), in the DBC's order. Left out are
/// a signal that the payload is too short for or that is not decodable, and what hangs on it as a switch;
/// everything of a remote or error frame. A switch is compared by its bits, never negative.
std::vector<DecodedSignal> decode_signals(const Message& message, const Frame& frame);

}  // namespace hystcan::can
