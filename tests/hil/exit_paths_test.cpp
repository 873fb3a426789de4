// The amplifiers end at their safe value however the controller ends: by a clean stop on a signal or a
// hang-up of the terminal, or by the amplifier's own watchdog if the process dies or hangs.
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>

#include <cstdlib>
#include <filesystem>
#include <optional>

#include "tests/hil/live_stage.h"
#include "tests/support/shows.h"

namespace hystcan::exit_paths_test {
namespace {

using hil::between;
using hil::json;
using hil::milliseconds;
using hil::now_s;
using hil::OnWire;
using hil::QuickStage;

struct ControllerProcess : testing::Test {
  QuickStage stage;

  /// Expects that the drive ramped down before the last command disabled the amplifier.
  void expect_clean_stop() {
    const json log = stage.log_at_rest();
    hil::expect_both_safe(log);
    hil::expect_stopped_by_a_ramp(log);
  }

  /// Expects that the amplifiers' own watchdogs switched them off, without a command of the controller.
  void expect_tripped() {
    const json log = stage.log_at_rest();
    hil::expect_both_safe(log);
    ASSERT_FALSE(log.at("first_fault").is_null());
    EXPECT_EQ(log.at("first_fault").at("fault"), 1) << "command timeout";
    EXPECT_EQ(log.at("last_command").at("enable"), 1) << "the controller died while tracking";
  }
};

TEST_F(ControllerProcess, StopsCleanlyOnSigterm) {
  shows("S-060");
  stage.start();
  stage.bench.controller->send(SIGTERM);
  EXPECT_EQ(stage.bench.controller->wait(), 0) << stage.bench.controller->err();
  expect_clean_stop();
}

TEST_F(ControllerProcess, LeavesTheStopToTheAmplifierOnSigkill) {
  shows("S-062");
  stage.start();
  stage.bench.controller->send(SIGKILL);
  EXPECT_EQ(stage.bench.controller->wait(), 128 + SIGKILL);
  expect_tripped();
}

/// Returns the threads of a process except the first one, which is the control thread.
std::vector<pid_t> other_threads(pid_t process) {
  std::vector<pid_t> threads;
  const std::filesystem::path folder = "/proc/" + std::to_string(process) + "/task";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const pid_t thread = std::stoi(entry.path().filename());
    if (thread != process) threads.push_back(thread);
  }
  return threads;
}

TEST_F(ControllerProcess, LeavesTheStopToTheAmplifierOnASegmentationFault) {
  shows("S-062");
  stage.start();
  const pid_t process = stage.bench.controller->pid();
  const std::vector<pid_t> threads = other_threads(process);
  ASSERT_GE(threads.size(), 2u) << "telemetry and control service";
  ASSERT_EQ(syscall(SYS_tgkill, process, threads.front(), SIGSEGV), 0);
  EXPECT_EQ(stage.bench.controller->wait(), 128 + SIGSEGV);
  expect_tripped();
}

/// The socket of a service manager; its address is in the environment while this object exists.
class Manager {
 public:
  Manager(std::string address, int watchdog_us) : address_(std::move(address)) {
    sockaddr_un address_un{};
    address_un.sun_family = AF_UNIX;
    address_.copy(address_un.sun_path, sizeof address_un.sun_path - 1);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address_un), sizeof address_un), 0);
    setenv("NOTIFY_SOCKET", address_.c_str(), 1);
    setenv("WATCHDOG_USEC", std::to_string(watchdog_us).c_str(), 1);
  }
  ~Manager() {
    close(socket_);
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
  }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  /// Returns the message that arrives within `limit`, or an empty text.
  std::string receives(milliseconds limit) const {
    pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
    if (poll(&waiting, 1, static_cast<int>(limit.count())) <= 0) return {};
    std::string text(256, '\0');
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(recv(socket_, text.data(), text.size(), 0), 0)));
    return text;
  }

 private:
  std::string address_;
  int socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

// systemd sends SIGABRT after WatchdogSec, and SIGCONT so that a stopped process receives it.
TEST_F(ControllerProcess, IsKilledByItsServiceManagerAfterItHangs) {
  shows("S-062, S-063");
  constexpr milliseconds watchdog{300};
  const Manager manager(stage.folder() + "/notify", 300'000);
  stage.start();
  EXPECT_EQ(manager.receives(watchdog), "READY=1\n");
  for (int i = 0; i < 5; ++i) EXPECT_EQ(manager.receives(watchdog), "WATCHDOG=1\n");
  stage.bench.controller->send(SIGSTOP);
  const double stopped_s = now_s();
  while (!manager.receives(watchdog).empty())
    ASSERT_LT(now_s(), stopped_s + 2.0) << "messages from before the hang must come to an end";
  const double killed_s = now_s();
  stage.bench.controller->send(SIGABRT);
  stage.bench.controller->send(SIGCONT);
  EXPECT_EQ(stage.bench.controller->wait(), 128 + SIGABRT);
  const json log = stage.log_at_rest();
  hil::expect_both_safe(log);
  ASSERT_FALSE(log.at("first_fault").is_null());
  EXPECT_EQ(log.at("first_fault").at("fault"), 1) << "command timeout";
  EXPECT_LT(log.at("first_fault").at("time_s"), killed_s - 0.2);
  EXPECT_TRUE(between(hil::series(log, "X", "AmpCommand"), killed_s, now_s()).empty());
}

/// Runs a command on its own terminal and stores the text on the screen.
class OnTerminal {
 public:
  explicit OnTerminal(std::vector<std::string> command) {
    std::vector<char*> arguments;
    arguments.reserve(command.size() + 1);
    for (std::string& word : command) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    child_ = forkpty(&terminal_, nullptr, nullptr, nullptr);
    if (child_ != 0) return;
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  ~OnTerminal() {
    hang_up();
    if (ended_) return;
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  OnTerminal(const OnTerminal&) = delete;
  OnTerminal& operator=(const OnTerminal&) = delete;

  bool shows(const std::string& text) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    while (screen_.find(text) == std::string::npos) {
      pollfd waiting{.fd = terminal_, .events = POLLIN, .revents = 0};
      if (std::chrono::steady_clock::now() > deadline || poll(&waiting, 1, 1000) < 0) return false;
      std::string part(4096, '\0');
      const ssize_t bytes = (waiting.revents & POLLIN) != 0 ? read(terminal_, part.data(), part.size()) : 0;
      if (bytes < 0) return false;
      screen_.append(part, 0, static_cast<std::size_t>(bytes));
    }
    return true;
  }
  void hang_up() {
    if (terminal_ >= 0) close(std::exchange(terminal_, -1));
  }
  /// Returns the exit status in the form of a shell; `nullopt` if the command still runs after ten seconds.
  std::optional<int> status() {
    for (int i = 0; i < 500; ++i) {
      int raw = 0;
      if (waitpid(child_, &raw, WNOHANG) == child_) {
        ended_ = true;
        return WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw);
      }
      std::this_thread::sleep_for(milliseconds(20));
    }
    return {};
  }
  const std::string& screen() const { return screen_; }

 private:
  int terminal_ = -1;
  pid_t child_ = -1;
  bool ended_ = false;
  std::string screen_;
};

TEST_F(ControllerProcess, StopsCleanlyWhenItsTerminalHangsUp) {
  shows("S-061");
  OnTerminal controller(
      hil::with_real_time_priority({HYSTCAN_PROGRAM, "controller", stage.config, "--interface", "vcan0"}));
  ASSERT_TRUE(controller.shows("x: tracking") && controller.shows("y: tracking")) << controller.screen();
  controller.hang_up();
  EXPECT_EQ(controller.status(), 0);
  expect_clean_stop();
}

TEST_F(ControllerProcess, ReloadsOnSighupWithoutATerminal) {
  shows("S-064");
  stage.start();
  stage.set("controller", "heartbeat_ms = 50.0");
  EXPECT_TRUE(
      stage.bench.controller->says("nothing was changed; a restart is needed: controller.heartbeat_ms"));
  stage.bench.controller->send(SIGHUP);
  const auto is_logged_again = [&] {
    const std::string log = stage.bench.controller->err();
    return log.find("a restart is needed") != log.rfind("a restart is needed");
  };
  EXPECT_TRUE(hil::eventually(is_logged_again)) << stage.bench.controller->err();
  EXPECT_TRUE(stage.bench.controller->running());
  EXPECT_EQ(stage.axis_status(0).at("state"), "tracking");
}

/// No other node is on the bus.
TEST(ControllerProcessWithoutNodes, ReportsTheMissingNodesAndExitsWithOne) {
  shows("S-053");
  hil::FreshVcan fresh;
  hil::Process controller(
      {HYSTCAN_PROGRAM, "controller", hil::config_file, "--interface", "vcan0", "--duration", "4"});
  EXPECT_EQ(controller.wait(), 1);
  EXPECT_NE(controller.err().find("x: still waits for a heartbeat of the sensor"), std::string::npos)
      << controller.err();
  EXPECT_NE(controller.err().find("nothing was tracked: x waited for a heartbeat of the sensor"),
            std::string::npos)
      << controller.err();
}

TEST(ControllerProcessWithoutNodes, ExitsWithOneOnSigterm) {
  hil::FreshVcan fresh;
  hil::Process controller({HYSTCAN_PROGRAM, "controller", hil::config_file, "--interface", "vcan0"});
  ASSERT_TRUE(controller.says("x: waiting for amplifier node"));
  controller.send(SIGTERM);
  EXPECT_EQ(controller.wait(), 1);
  EXPECT_NE(controller.err().find("nothing was tracked: x waited for"), std::string::npos)
      << controller.err();
}

TEST(ControllerProcessWithoutNodes, ExitsWithZeroIfTheUserHasDisabledEveryAxis) {
  hil::FreshVcan fresh;
  hil::Process controller({HYSTCAN_PROGRAM, "controller", hil::config_file, "--interface", "vcan0"});
  ASSERT_TRUE(controller.says("x: waiting for amplifier node"));
  hil::Process disable({HYSTCAN_PROGRAM, "ctl", "disable"});
  ASSERT_EQ(disable.wait(), 0) << disable.err();
  ASSERT_TRUE(controller.says("y: offline"));
  controller.send(SIGTERM);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
}

}  // namespace
}  // namespace hystcan::exit_paths_test
