// Listens to everything on an interface: frames of every node and of this host's programs, error frames, and
// how many the kernel has dropped.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "can/log/candump.h"
#include "can/socketcan/raw_socket.h"

namespace hystcan::can {

/// Where the interface goes down or vanishes the tap waits until it is back.
class BusMonitor {
 public:
  using Handler = std::function<void(const LoggedFrame& frame)>;

  /// Throws InterfaceError.
  explicit BusMonitor(const std::string& interface);
  ~BusMonitor();
  BusMonitor(const BusMonitor&) = delete;
  BusMonitor& operator=(const BusMonitor&) = delete;

  /// Waits at most that long for a frame, or until a signal; then hands on all that are there. Frames that
  /// the kernel has dropped are told by a drop_notice() in their place.
  void listen(std::chrono::milliseconds at_most, const Handler& handler);

  /// Tells what was dropped after the last frame that was handed on.
  void finish(const Handler& handler);

  bool up() const { return up_; }
  std::uint64_t lost() const { return lost_; }

 private:
  /// One batch. Returns its size; -1 as ReceiveBatch::read().
  int take(const Handler& handler);
  void reopen();
  void tell_lost(std::uint32_t lost_of_socket, std::chrono::microseconds time, const Handler& handler);

  std::string interface_;
  int socket_;
  bool up_ = true;
  std::optional<ReceiveBatch> batch_;  ///< a new one for each socket, for it keeps count of what was lost
  std::uint32_t lost_of_socket_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace hystcan::can
