// What a SocketCAN error frame says of the controller's state.
#pragma once

#include <optional>

#include "can/bus.h"

namespace hystcan::can {

/// `error_frame`: kind `error`, its id the error classes of linux/can/error.h. Empty where it tells no state.
std::optional<BusState> state_told_by(const Frame& error_frame);

}  // namespace hystcan::can
