// What the program tells the service manager that started it (systemd's notification protocol, sd_notify(3)):
// that it runs, and that its cycles go on. Without one (no NOTIFY_SOCKET) nothing is told.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace hystcan::app {

/// On the telemetry thread: a datagram, sent without waiting.
class SystemdNotifier {
 public:
  /// `socket` and `watchdog_us`: as in NOTIFY_SOCKET and WATCHDOG_USEC.
  SystemdNotifier(std::string socket, std::string_view watchdog_us);
  ~SystemdNotifier();
  SystemdNotifier(const SystemdNotifier&) = delete;
  SystemdNotifier& operator=(const SystemdNotifier&) = delete;
  static SystemdNotifier of_environment();

  /// A cycle that began at `time_s` has been closed. The first one tells READY=1; then WATCHDOG=1, three
  /// times in what the manager waits. Cycles that do not come are what it waits for in vain.
  void tell_cycle(double time_s);

 private:
  void tell(std::string_view text);

  std::string address_;
  int socket_ = -1;
  std::optional<double> interval_s_;  ///< empty: no watchdog
  std::optional<double> told_s_;
};

}  // namespace hystcan::app
