// The contents of a SocketCAN error frame (linux/can/error.h). The error classes are in the identifier, the
// details in the payload:
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
  std::optional<BusState> state;  ///< state of the controller; nullopt if the frame does not contain it
  /// nullopt if the frame has no counters. New drivers mark them with CAN_ERR_CNT; old drivers send them
  /// with a state.
  std::optional<ErrorCounters> error_counters;
  bool restarted = false;         ///< the controller restarted after bus-off
  bool not_acknowledged = false;  ///< no other node received the frame
  bool arbitration_lost = false;
  bool protocol_error = false;  ///< bit, stuff, form, CRC, overload
  bool controller_overflow = false;
  bool transceiver_error = false;
};

/// Interprets an error frame: its kind must be `error`; its identifier contains the error classes.
ErrorReport interpret(const Frame& error_frame);

/// Counts the causes of one error frame, but no change of state: a frame may repeat the present state.
void count(const ErrorReport& report, BusCounters& counters);

// The text of an error frame: the classes and details of linux/can/error.h.

/// Returns the causes without numbers, so that a caller can count them: "bus-off", "not acknowledged", "stuff
/// error". An error class without details counts as one cause. The result is never empty.
std::vector<std::string> error_causes(const Frame& error_frame);

/// Returns one line: the causes, the bit of lost arbitration, the place of a protocol error and the error
/// counters.
std::string describe_error(const Frame& error_frame);

}  // namespace hystcan::can
