#include "app/live/systemd_notifier.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <vector>

#include "tests/support/scratch.h"

namespace hystcan::systemd_notifier_test {
namespace {

/// The service manager's end of the notification socket.
class Manager {
 public:
  Manager() : path_(support::scratch_file("notify")) {
    std::filesystem::remove(path_);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.string().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~Manager() {
    ::close(socket_);
    std::filesystem::remove(path_);
  }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  std::string path() const { return path_.string(); }
  std::vector<std::string> messages() const {
    std::vector<std::string> texts;
    std::array<char, 100> text{};
    for (ssize_t n = 0; (n = ::recv(socket_, text.data(), text.size(), MSG_DONTWAIT)) > 0;)
      texts.emplace_back(text.data(), static_cast<std::size_t>(n));
    return texts;
  }

 private:
  std::filesystem::path path_;
  int socket_ = ::socket(AF_UNIX, SOCK_DGRAM, 0);
};

TEST(SystemdNotifier, SendsReadyThenWatchdogThreeTimesPerTimeout) {
  const Manager manager;
  app::SystemdNotifier service(manager.path(), "300000");
  for (int ms = 0; ms <= 1000; ++ms) service.report_cycle(1e-3 * ms);
  const auto messages = manager.messages();
  ASSERT_GE(messages.size(), 2u);
  EXPECT_EQ(messages.front(), "READY=1\n");
  for (std::size_t i = 1; i < messages.size(); ++i) EXPECT_EQ(messages[i], "WATCHDOG=1\n");
  EXPECT_GE(messages.size() - 1, 9u) << "every 0.1 s, or the cycle after it";
  EXPECT_LE(messages.size() - 1, 10u);
}

TEST(SystemdNotifier, SendsNothingWithoutCycles) {
  const Manager manager;
  const app::SystemdNotifier service(manager.path(), "300000");
  EXPECT_TRUE(manager.messages().empty());
}

TEST(SystemdNotifier, SendsOnlyReadyWithoutAWatchdog) {
  const Manager manager;
  app::SystemdNotifier service(manager.path(), "");
  for (int ms = 0; ms <= 1000; ++ms) service.report_cycle(1e-3 * ms);
  EXPECT_EQ(manager.messages(), std::vector<std::string>{"READY=1\n"});
}

TEST(SystemdNotifier, IgnoresAMissingManager) {
  app::SystemdNotifier none("", "300000");
  app::SystemdNotifier gone("/nonexistent/notify", "300000");
  none.report_cycle(0.0);
  gone.report_cycle(0.0);
  gone.report_cycle(1.0);
}

}  // namespace
}  // namespace hystcan::systemd_notifier_test
