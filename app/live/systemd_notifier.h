// Tells the service manager (systemd, sd_notify(3)) that the program has started and that its cycles
// continue. Without a service manager (NOTIFY_SOCKET is not set) it sends nothing.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace hystcan::app {

/// Sends each notification as a datagram without waiting. Runs on the telemetry thread.
class SystemdNotifier {
 public:
  /// `socket` and `watchdog_us`: values of the environment variables NOTIFY_SOCKET and WATCHDOG_USEC.
  SystemdNotifier(std::string socket, std::string_view watchdog_us);
  ~SystemdNotifier();
  SystemdNotifier(const SystemdNotifier&) = delete;
  SystemdNotifier& operator=(const SystemdNotifier&) = delete;
  static SystemdNotifier from_environment();

  /// Reports a complete cycle that began at `time_s`. The first call sends READY=1. Later calls send
  /// WATCHDOG=1 three times per watchdog interval. If no cycle is reported for a whole interval, the
  /// manager's watchdog expires.
  void report_cycle(double time_s);

 private:
  void send(std::string_view text);

  std::string address_;
  int socket_ = -1;
  std::optional<double> interval_s_;  ///< time between two notifications; nullopt: the manager has no
                                      ///< watchdog
  std::optional<double> last_sent_s_;
};

}  // namespace hystcan::app
