// Notifies the service manager (systemd's notification protocol, sd_notify(3)) that the program runs and that
// its cycles continue. Without a service manager (no NOTIFY_SOCKET) it sends nothing.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace hystcan::app {

/// Runs on the telemetry thread. Each notification is a datagram, sent without waiting.
class SystemdNotifier {
 public:
  /// `socket` and `watchdog_us` have the form of NOTIFY_SOCKET and WATCHDOG_USEC.
  SystemdNotifier(std::string socket, std::string_view watchdog_us);
  ~SystemdNotifier();
  SystemdNotifier(const SystemdNotifier&) = delete;
  SystemdNotifier& operator=(const SystemdNotifier&) = delete;
  static SystemdNotifier from_environment();

  /// Reports a complete cycle that began at `time_s`. The first call sends READY=1. Later calls send
  /// WATCHDOG=1, three times per watchdog interval. If cycles stop, the manager's watchdog expires.
  void report_cycle(double time_s);

 private:
  void send(std::string_view text);

  std::string address_;
  int socket_ = -1;
  std::optional<double> interval_s_;  ///< nullopt: no watchdog
  std::optional<double> last_sent_s_;
};

}  // namespace hystcan::app
