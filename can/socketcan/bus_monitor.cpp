#include "can/socketcan/bus_monitor.h"

#include <linux/can/raw.h>
#include <linux/sock_diag.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <thread>

#include "base/error.h"
#include "base/input_file.h"
#include "can/socketcan/interface.h"

namespace hystcan::can {
namespace {

// Without CAP_NET_ADMIN, the kernel limits the receive buffer to net.core.rmem_max.
constexpr int receive_buffer_bytes = 8 << 20;
constexpr std::chrono::milliseconds reopen_every{50};

int open_tap(const std::string& interface) {
  Descriptor socket(open_raw_socket(interface, {}));
  const can_filter everything{0, 0};
  if (::setsockopt(socket.get(), SOL_CAN_RAW, CAN_RAW_FILTER, &everything, sizeof everything) != 0)
    fail_at_interface(interface, "cannot receive every frame");
  for (const int option : {SO_RCVBUFFORCE, SO_RCVBUF})
    if (::setsockopt(socket.get(), SOL_SOCKET, option, &receive_buffer_bytes, sizeof receive_buffer_bytes) ==
        0)
      break;
  return socket.release();
}

/// Returns the number of frames that the kernel has dropped on this socket until now.
std::uint32_t drops_of(int socket) {
  std::array<std::uint32_t, SK_MEMINFO_VARS> values{};
  socklen_t bytes = sizeof values;
  ::getsockopt(socket, SOL_SOCKET, SO_MEMINFO, values.data(), &bytes);
  return values[SK_MEMINFO_DROPS];
}

std::chrono::microseconds time_of_day() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::system_clock::now().time_since_epoch());
}

}  // namespace

BusMonitor::BusMonitor(const std::string& interface) : interface_(interface), socket_(open_tap(interface)) {
  batch_.emplace();
}

BusMonitor::~BusMonitor() { ::close(socket_); }

void BusMonitor::listen(std::chrono::milliseconds at_most, const Handler& handler) {
  if (!up_) {
    std::this_thread::sleep_for(std::min(at_most, reopen_every));
    reopen();
    return;
  }
  pollfd waiting{socket_, POLLIN, 0};
  if (::poll(&waiting, 1, static_cast<int>(at_most.count())) <= 0) return;
  if (take(handler) >= 0 || errno == EAGAIN || errno == EINTR) return;
  up_ = false;
  while (take(handler) > 0) continue;  // reads frames that arrived before the interface went down
  finish(handler);
}

int BusMonitor::take(const Handler& handler) {
  const int count = batch_->read(socket_);
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(count, 0)); ++i) {
    LoggedFrame logged;
    logged.time = std::chrono::duration_cast<std::chrono::microseconds>(batch_->stamped(i));
    logged.interface = interface_;
    logged.frame = batch_->frame(i);
    report_lost(batch_->lost(), logged.time, handler);
    handler(logged);
  }
  return count;
}

void BusMonitor::finish(const Handler& handler) { report_lost(drops_of(socket_), time_of_day(), handler); }

void BusMonitor::report_lost(std::uint32_t lost_of_socket, std::chrono::microseconds time,
                             const Handler& handler) {
  const std::uint32_t more = lost_of_socket - lost_of_socket_;
  if (more == 0) return;
  lost_of_socket_ = lost_of_socket;
  lost_ += more;
  handler({time, interface_, drop_notice(more), Direction::unstated});
}

// Opens a new socket: an adapter that was unplugged and plugged in again is a new interface for the kernel.
void BusMonitor::reopen() {
  try {
    const int socket = open_tap(interface_);
    ::close(socket_);
    socket_ = socket;
    lost_of_socket_ = 0;
    batch_.emplace();
    up_ = true;
  } catch (const RunError&) {
    up_ = false;
  }
}

}  // namespace hystcan::can
