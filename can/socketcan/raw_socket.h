// A CAN_RAW socket: opens it with our options, reads it in batches, and writes to it without waiting.
//
// Arrival times are the kernel's software stamps. The kernel takes them in the receive interrupt of the
// adapter, on the clock that all interfaces share. We do not use the adapter's own stamps (SO_TIMESTAMPING,
// raw hardware): they count on a free-running crystal that the kernel does not relate to our clock. An
// estimate of the offset would have an error of 100 us in a second at 100 ppm, more than the interrupt
// latency that it would remove.
#pragma once

#include <linux/can.h>
#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "can/frame.h"
#include "can/scheduler.h"
#include "can/socketcan/socketcan_bus.h"

namespace hystcan::can {

/// Opens a non-blocking socket and binds it to the interface. Before the bind, the function sets the filters
/// and enables error frames and kernel time stamps. The caller closes the socket. Throws RunError.
int open_raw_socket(const std::string& interface, std::span<const Filter> filters);

/// Enables the echo of the socket's own frames; the socket's filters apply to the echo.
void receive_own_frames(int socket);

/// Returns 0, or the errno with which the kernel refused the frame.
int write_frame(int socket, const Frame& frame);

/// The frames that one system call returns.
class ReceiveBatch {
 public:
  static constexpr std::size_t capacity = 16;

  ReceiveBatch();
  ReceiveBatch(const ReceiveBatch&) = delete;
  ReceiveBatch& operator=(const ReceiveBatch&) = delete;

  /// Reads at most `room` frames; `room` is 1 to `capacity`. Waits only if `room` is 1 and the socket is
  /// blocking. Returns the number of frames, or -1 with the reason in errno.
  int read(int socket, std::size_t room = capacity);

  Frame frame(std::size_t index) const;
  /// The arrival time: the kernel's time stamp, converted to the steady clock. If the stamp is implausible,
  /// the time at which the frame was read.
  Time received(std::size_t index) const { return received_[index]; }
  /// The kernel's unchanged time stamp, as the time since 1970-01-01 UTC.
  Duration stamped(std::size_t index) const { return stamped_[index]; }
  /// Returns true for the echo of a frame that this socket sent.
  bool is_own(std::size_t index) const { return (headers_[index].msg_hdr.msg_flags & MSG_CONFIRM) != 0; }
  /// The number of frames that the kernel dropped on this socket since it was opened.
  std::uint32_t lost() const { return lost_; }
  /// Sets the number of dropped frames to 0. Call this function before the first read from a new socket.
  void restart() { lost_ = 0; }

 private:
  static constexpr std::size_t control_bytes = 64;

  int read_one(int socket);
  void read_control(std::size_t index, Time steady_now, Duration realtime_now);

  std::array<mmsghdr, capacity> headers_{};
  std::array<iovec, capacity> vectors_{};
  std::array<canfd_frame, capacity> frames_{};
  static_assert(control_bytes % alignof(cmsghdr) == 0);
  alignas(cmsghdr) std::array<std::array<char, control_bytes>, capacity> control_{};
  std::array<Time, capacity> received_{};
  std::array<Duration, capacity> stamped_{};
  std::uint32_t lost_ = 0;
};

}  // namespace hystcan::can
