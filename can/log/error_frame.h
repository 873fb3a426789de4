// Interprets an error frame of SocketCAN (linux/can/error.h). Its identifier contains the error classes, and
// its payload contains the details:
//
//   byte 1  controller: overflow, warning, passive, active      byte 4      transceiver
//   byte 2  protocol violation: kind                            bytes 6, 7  TX and RX error counter
//   byte 3  protocol violation: place in the frame
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "can/bus.h"
#include "can/frame.h"

namespace hystcan::can {

struct ErrorReport {
  std::optional<BusState> state;  ///< state of the CAN controller; nullopt if the frame reports no state
  /// Error counters of the CAN controller; nullopt if the frame has none. New drivers mark a frame that has
  /// counters with CAN_ERR_CNT. Old drivers have no mark: they send counters in a frame about the state.
  std::optional<ErrorCounters> error_counters;
  bool restarted = false;         ///< the CAN controller restarted after bus-off
  bool not_acknowledged = false;  ///< no other node acknowledged the frame that was sent
  bool arbitration_lost = false;
  bool protocol_error = false;  ///< a bit, stuff, form or CRC error, or an overload
  bool controller_overflow = false;
  bool transceiver_error = false;
};

/// Interprets an error frame. The kind of the frame must be FrameKind::error.
ErrorReport interpret(const Frame& error_frame);

/// Adds the causes of one error frame to the counters. Does not count changes of state, because an error
/// frame may repeat the present state.
void count(const ErrorReport& report, BusCounters& counters);

// The functions below describe an error frame in words: the classes and details of linux/can/error.h.

/// Returns the causes of an error frame as texts without numbers, so that a caller can count equal texts:
/// "bus-off", "not acknowledged", "stuff error". An error class without details counts as one cause. The
/// result is never empty.
std::vector<std::string> error_causes(const Frame& error_frame);

/// Returns one line about an error frame: its causes, the bit at which arbitration was lost, the place of a
/// protocol error in the frame, and the error counters.
std::string describe_error(const Frame& error_frame);

}  // namespace hystcan::can
