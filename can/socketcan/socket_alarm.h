// Ends a wait in a blocking socket at a deadline, with the resolution of a timer.
#pragma once

#include <ctime>

#include "can/scheduler.h"

namespace hystcan::can {

/// The kernel's own time limit of a read (SO_RCVTIMEO) has the resolution of its tick, 4 ms, so this alarm
/// uses a signal. The signal makes the socket non-blocking: a read that waits, or that begins later, then
/// fails with EAGAIN. All other system calls are restarted after the signal.
class SocketAlarm {
 public:
  /// Interrupts the calling thread. Throws RunError if the user may have no more timers.
  explicit SocketAlarm(int socket);
  ~SocketAlarm();
  SocketAlarm(const SocketAlarm&) = delete;
  SocketAlarm& operator=(const SocketAlarm&) = delete;

  /// Makes the socket blocking until the deadline, which replaces the one before.
  void set(Time deadline);

 private:
  int socket_;
  timer_t timer_{};
};

}  // namespace hystcan::can
