// Receives everything on an interface: frames of every node and of this host's programs, error frames, and
// the number of frames that the kernel dropped.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "can/log/candump.h"
#include "can/socketcan/raw_socket.h"

namespace hystcan::can {

/// If the interface goes down or disappears, the monitor waits until it is up again.
class BusMonitor {
 public:
  using Handler = std::function<void(const LoggedFrame& frame)>;

  /// Throws RunError if the interface can't be used.
  explicit BusMonitor(const std::string& interface);
  ~BusMonitor();
  BusMonitor(const BusMonitor&) = delete;
  BusMonitor& operator=(const BusMonitor&) = delete;

  /// Waits for a frame or a signal, for at most `at_most`; then passes all available frames to the handler. A
  /// drop_notice() replaces the frames that the kernel dropped.
  void listen(std::chrono::milliseconds at_most, const Handler& handler);

  /// Reports the frames that the kernel dropped after the last received frame.
  void finish(const Handler& handler);

  bool up() const { return up_; }
  std::uint64_t lost() const { return lost_; }

 private:
  /// Reads one batch and returns its size, or -1 like ReceiveBatch::read().
  int take(const Handler& handler);
  void reopen();
  void report_lost(std::uint32_t lost_of_socket, std::chrono::microseconds time, const Handler& handler);

  std::string interface_;
  int socket_;
  bool up_ = true;
  std::optional<ReceiveBatch> batch_;  ///< new for each socket, because it counts the lost frames
  std::uint32_t lost_of_socket_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace hystcan::can
