// A CAN_RAW socket: opened with our options, read in batches, written to without waiting.
//
// Arrival times are the kernel's software stamps, taken in the adapter's receive interrupt on the clock that
// all interfaces share. An adapter's own stamps (SO_TIMESTAMPING, raw hardware) are not used: they count on a
// free-running crystal of the adapter which the kernel does not relate to ours; an estimate of the offset
// would err by 100 us in a second at 100 ppm, more than the interrupt's latency that it would take away.
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

/// A nonblocking socket bound to the interface; filters are set before bind, error frames and kernel time
/// stamps are on. The caller closes it. Throws InterfaceError.
int open_raw_socket(const std::string& interface, std::span<const Filter> filters);

/// Zero, or the errno with which the kernel refused the frame. `fd_flags`: of an FD frame (CANFD_BRS, ...).
int write_frame(int socket, const Frame& frame, std::uint8_t fd_flags = 0);

/// Room for the frames of one system call.
class ReceiveBatch {
 public:
  static constexpr std::size_t capacity = 16;

  ReceiveBatch();
  ReceiveBatch(const ReceiveBatch&) = delete;
  ReceiveBatch& operator=(const ReceiveBatch&) = delete;

  /// How many frames were there, at most `room`, which is 1 to `capacity`; or -1, and errno says why.
  int read(int socket, std::size_t room = capacity);

  Frame frame(std::size_t index) const;
  /// When the frame arrived by the kernel's stamp, as steady time; the time of reading where that makes no
  /// sense.
  Time received(std::size_t index) const { return received_[index]; }
  /// The same as time of day, since 1970-01-01 UTC: the kernel's stamp as it stands.
  Duration stamped(std::size_t index) const { return stamped_[index]; }
  std::uint8_t fd_flags(std::size_t index) const { return frames_[index].flags; }
  /// Frames the kernel has dropped on this socket since it was opened.
  std::uint32_t lost() const { return lost_; }
  /// The next read is from a socket just opened.
  void restart() { lost_ = 0; }

 private:
  static constexpr std::size_t control_bytes = 64;

  void read_control(std::size_t index, Time steady_now, Duration realtime_now);

  std::array<mmsghdr, capacity> headers_{};
  std::array<iovec, capacity> vectors_{};
  std::array<canfd_frame, capacity> frames_{};
  struct alignas(cmsghdr) Control {
    std::array<char, control_bytes> bytes;
  };
  std::array<Control, capacity> control_{};
  std::array<Time, capacity> received_{};
  std::array<Duration, capacity> stamped_{};
  std::uint32_t lost_ = 0;
};

}  // namespace hystcan::can
