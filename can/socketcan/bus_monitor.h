// Receives all frames on a CAN interface: frames of other nodes, frames of programs on this computer, and
// error frames. Counts the frames that the kernel dropped.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "can/log/candump.h"
#include "can/socketcan/raw_socket.h"

namespace hystcan::can {

/// Receives all frames on an interface. If the interface goes down or disappears, the monitor waits until the
/// interface is up again.
class BusMonitor {
 public:
  using Handler = std::function<void(const LoggedFrame& frame)>;

  /// Throws RunError if the interface can't be used.
  explicit BusMonitor(const std::string& interface);
  ~BusMonitor();
  BusMonitor(const BusMonitor&) = delete;
  BusMonitor& operator=(const BusMonitor&) = delete;

  /// Waits for a frame or a signal of the operating system, but not longer than `at_most`. Then passes all
  /// available frames to the handler. If the kernel dropped frames, the handler receives a drop_notice().
  void listen(std::chrono::milliseconds at_most, const Handler& handler);

  /// Passes a drop_notice() to the handler if the kernel dropped frames after the last received frame.
  void finish(const Handler& handler);

  bool up() const { return up_; }
  std::uint64_t lost() const { return lost_; }

 private:
  /// Reads one batch of frames and passes the frames to the handler. Returns the number of frames, or -1 with
  /// errno like ReceiveBatch::read().
  int take(const Handler& handler);
  void reopen();
  void report_lost(std::uint32_t lost_of_socket, std::chrono::microseconds time, const Handler& handler);

  std::string interface_;
  int socket_;
  bool up_ = true;
  std::optional<ReceiveBatch> batch_;  ///< replaced with each new socket, because it counts the lost frames
                                       ///< of one socket
  std::uint32_t lost_of_socket_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace hystcan::can
