// What a SocketCAN error frame tells (linux/can/error.h: classes in the identifier, details in the payload).
//
//   byte 1  controller: overflow, warning, passive, active      byte 4      transceiver
//   byte 2  protocol violation: kind                            bytes 6, 7  TX and RX error counter
//   byte 3  protocol violation: place in the frame
#pragma once

#include <optional>

#include "can/bus.h"

namespace hystcan::can {

struct ErrorReport {
  std::optional<BusState> state;  ///< the controller's, where the frame tells one
  /// Where the driver gives them: by CAN_ERR_CNT or, as was done before there was that flag, beside a state.
  std::optional<ErrorCounters> error_counters;
  bool restarted = false;         ///< after bus-off
  bool not_acknowledged = false;  ///< nobody else was there to hear the frame
  bool arbitration_lost = false;
  bool protocol_error = false;  ///< bit, stuff, form, CRC, overload
  bool controller_overflow = false;
  bool transceiver_error = false;
};

/// `error_frame`: kind `error`, its id the error classes.
ErrorReport interpret(const Frame& error_frame);

/// Adds what one error frame told. Changes of state are not in it: the frame may repeat a state known before.
void count(const ErrorReport& report, BusCounters& counters);

/// The controller has entered this state from another.
void count_entry(BusState state, BusCounters& counters);

}  // namespace hystcan::can
