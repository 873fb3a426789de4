#include "app/live/systemd_notifier.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>

namespace hystcan::app {
namespace {

constexpr double notifications_per_timeout = 3.0;

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

SystemdNotifier::SystemdNotifier(std::string socket, std::string_view watchdog_us)
    : address_(std::move(socket)) {
  if (address_.empty() || address_.size() >= sizeof sockaddr_un{}.sun_path) return;
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  std::uint64_t us = 0;
  const char* const end = watchdog_us.data() + watchdog_us.size();
  if (std::from_chars(watchdog_us.data(), end, us).ec == std::errc() && us > 0)
    interval_s_ = 1e-6 * static_cast<double>(us) / notifications_per_timeout;
}

SystemdNotifier::~SystemdNotifier() {
  if (socket_ >= 0) ::close(socket_);
}

SystemdNotifier SystemdNotifier::from_environment() {
  return {variable("NOTIFY_SOCKET"), variable("WATCHDOG_USEC")};
}

void SystemdNotifier::report_cycle(double time_s) {
  if (socket_ < 0) return;
  if (!last_sent_s_)
    send("READY=1\n");
  else if (!interval_s_ || time_s < *last_sent_s_ + *interval_s_)
    return;
  else
    send("WATCHDOG=1\n");
  last_sent_s_ = time_s;
}

/// Sends the text without waiting and ignores failures. If the service manager receives nothing, its watchdog
/// expires.
void SystemdNotifier::send(std::string_view text) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  address_.copy(address.sun_path, sizeof address.sun_path - 1);
  if (address.sun_path[0] == '@') address.sun_path[0] = '\0';  // abstract socket
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  ::sendto(socket_, text.data(), text.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address),
           length);
}

}  // namespace hystcan::app
