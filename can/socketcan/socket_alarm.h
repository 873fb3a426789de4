// Ends a wait in a blocking socket at a deadline, with the resolution of a timer.
#pragma once

#include <ctime>

#include "can/scheduler.h"

namespace hystcan::can {

/// Ends a wait in a read with a signal. The kernel's own time limit of a read (SO_RCVTIMEO) has a resolution
/// of only 4 ms. The signal makes the socket non-blocking: a read that waits, or that begins later, then
/// fails with EAGAIN. All other system calls are restarted after the signal.
class SocketAlarm {
 public:
  /// The alarm will interrupt the thread that calls this constructor. Throws RunError if the kernel gives the
  /// user no further timer.
  explicit SocketAlarm(int socket);
  ~SocketAlarm();
  SocketAlarm(const SocketAlarm&) = delete;
  SocketAlarm& operator=(const SocketAlarm&) = delete;

  /// Makes the socket blocking until the deadline. Replaces the previous deadline.
  void set(Time deadline);

 private:
  int socket_;
  timer_t timer_{};
};

}  // namespace hystcan::can
