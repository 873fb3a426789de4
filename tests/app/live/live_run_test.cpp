// The ends of a live run: after any of them, every axis is at its safe drive. The stage runs in virtual time,
// which a timer of the run's event loop advances: no test depends on the speed of the machine.
#include "app/live/live_run.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/rehearsed.h"
#include "tests/support/shows.h"

namespace hystcan::app::live_run_test {
namespace {

using controller::AxisState;
using std::chrono::milliseconds;

class LiveStage : public testing::Test {
 protected:
  LiveStage() {
    tester_->on_frame([this](const can::Frame& frame, can::Time) {
      if (frame.id == command_id) last_command_ = frame;
    });
    rehearsal_.twin().start();
    pump_ = loop_.scheduler().make_timer([this] {
      rehearsal_.run_for(milliseconds(5));
      if (on_turn_) on_turn_();
      if (++turns_ == most_turns) loop_.stop();
      pump_->expire_at(loop_.scheduler().now());
    });
    pump_->expire_at(loop_.scheduler().now());
  }

  controller::Controller& controller() { return rehearsal_.controller(); }
  bool all_are(AxisState state) {
    for (std::size_t i = 0; i < controller().axis_count(); ++i)
      if (controller().axis(i).state() != state) return false;
    return true;
  }
  double output_V(std::size_t axis) { return rehearsal_.twin().axes()[axis]->plant.drive(); }
  /// Both amplifiers have latched a fault before the run.
  void latch_faults() {
    rehearsal_.run_for(milliseconds(500));
    for (const auto& axis : rehearsal_.twin().axes()) {
      axis->amplifier.begin_internal_fault();
      axis->amplifier.end_internal_fault();
    }
  }
  /// Raises the signal once, when all axes track and x is driven.
  void signal_while_tracking(int signal) {
    on_turn_ = [this, signal, raised = false]() mutable {
      if (raised || !all_are(AxisState::tracking) || output_V(0) < 20.0) return;
      raised = true;
      raise(signal);
    };
  }
  LiveRun until(std::function<bool()> done) {
    return {.is_done = [done = std::move(done)](double) { return done(); },
            .before_stop =
                [this] {
                  ++stops_;
                  tracked_at_stop_ = all_are(AxisState::tracking);
                },
            .reload = [this] { ++reloads_; }};
  }
  LiveRun for_ever() {
    return until([] { return false; });
  }
  void run(const LiveRun& run) { run_live(loop_, controller(), bus_log_, run); }
  /// Expects a clean end: each axis has ramped down and is off, and the last command is safe.
  void expect_ramped_down() {
    EXPECT_LT(turns_, most_turns);
    EXPECT_EQ(stops_, 1);
    EXPECT_TRUE(tracked_at_stop_) << "it is told before the ramp";
    EXPECT_TRUE(all_are(AxisState::offline));
    EXPECT_NEAR(output_V(0), 0.0, 1.0) << "the drive was ramped, before it was switched off";
    expect_last_command_is_safe();
  }
  void expect_last_command_is_safe() {
    rehearsal_.run_for(milliseconds(5));
    ASSERT_TRUE(last_command_);
    EXPECT_EQ(last_command_->data[4], 0) << "not enabled";
  }

  static constexpr std::uint32_t command_id = 0x201;
  static constexpr int most_turns = 20'000;  // 100 s of virtual time
  LiveLoop loop_{"none"};
  rehearsal::Rehearsal rehearsal_{support::shipped("piezo.toml"), support::ignore};
  std::unique_ptr<can::Bus> tester_ = rehearsal_.attach()({});
  std::vector<std::string> bus_lines_;
  can::BusHealthLog bus_log_{
      "none", [this](can::BusHealthLog::Level, const std::string& line) { bus_lines_.push_back(line); }};
  std::optional<can::Frame> last_command_;
  std::function<void()> on_turn_;
  std::unique_ptr<can::Timer> pump_;
  int turns_ = 0;
  int stops_ = 0;
  int reloads_ = 0;
  bool tracked_at_stop_ = false;
};

TEST_F(LiveStage, RampsDownWhenTheRunIsDone) {
  run(until([this] { return all_are(AxisState::tracking) && output_V(0) > 20.0; }));
  expect_ramped_down();
}

TEST_F(LiveStage, ChecksItsEndConditionEveryTwentyMilliseconds) {
  double longest_s = -1.0;
  int asked = 0;
  LiveRun live = for_ever();
  live.is_done = [&](double run_s) {
    EXPECT_GE(run_s, std::max(longest_s, 0.0));
    longest_s = run_s;
    ++asked;
    return run_s > 0.1;
  };
  run(live);
  EXPECT_GT(longest_s, 0.1);
  EXPECT_LE(asked, longest_s / 0.02 + 1e-6) << "a slow machine asks less often";
}

class EndingSignal : public LiveStage, public testing::WithParamInterface<int> {};

TEST_P(EndingSignal, RampsDown) {
  shows("S-060");
  signal_while_tracking(GetParam());
  run(for_ever());
  expect_ramped_down();
  EXPECT_EQ(reloads_, 0);
}
INSTANTIATE_TEST_SUITE_P(Signals, EndingSignal, testing::Values(SIGINT, SIGTERM, SIGQUIT, SIGXCPU));

TEST_F(LiveStage, IgnoresAccidentalSignals) {
  on_turn_ = [this, raised = false]() mutable {
    if (raised || !all_are(AxisState::tracking)) return;
    raised = true;
    for (const int signal : {SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF, SIGIO, SIGPWR, SIGSTKFLT, SIGTTIN,
                             SIGTTOU, SIGRTMIN, SIGRTMAX, SIGURG, SIGWINCH, SIGCHLD})
      raise(signal);
  };
  run(until([this] { return turns_ >= 1000 && output_V(0) > 20.0; }));
  expect_ramped_down();
}

TEST_F(LiveStage, FinishesItsRampIfTheProcessorTimeIsExceededTwice) {
  on_turn_ = [this] {
    if (all_are(AxisState::tracking) && output_V(0) > 20.0) raise(SIGXCPU);
    if (stops_ == 1) raise(SIGXCPU);
  };
  run(for_ever());
  expect_ramped_down();
}

TEST_F(LiveStage, ReloadsItsConfigurationOnAHangUp) {
  shows("S-064");
  signal_while_tracking(SIGHUP);
  run(until([this] { return reloads_ == 1; }));
  EXPECT_EQ(reloads_, 1);
  expect_ramped_down();
}

TEST_F(LiveStage, RampsDownOnAHangUpIfReloadIsUnavailable) {
  signal_while_tracking(SIGHUP);
  LiveRun live = for_ever();
  live.reload = {};
  run(live);
  expect_ramped_down();
}

TEST_F(LiveStage, StopsWithoutAStopCallback) {
  signal_while_tracking(SIGTERM);
  LiveRun live = for_ever();
  live.before_stop = {};
  run(live);
  EXPECT_TRUE(all_are(AxisState::offline));
}

TEST_F(LiveStage, ASecondSignalSkipsTheRampButSendsTheSafeCommand) {
  on_turn_ = [this, raised = 0]() mutable {
    if (raised == 0 && all_are(AxisState::tracking) && output_V(0) > 20.0)
      raised += raise(SIGTERM) == 0 ? 1 : 0;
    if (raised == 1 && stops_ == 1) raised += raise(SIGTERM) == 0 ? 1 : 0;
  };
  run(for_ever());
  EXPECT_EQ(stops_, 1);
  EXPECT_FALSE(all_are(AxisState::offline)) << "the ramp was not waited for";
  EXPECT_GT(output_V(0), 5.0);
  expect_last_command_is_safe();
}

TEST_F(LiveStage, RampsDownOnARequestToStop) {
  shows("S-060");
  controller::RequestLink requests;
  controller().listen_to(requests);
  on_turn_ = [&, asked = false]() mutable {
    if (asked || !all_are(AxisState::tracking)) return;
    asked = true;
    auto stop = std::make_unique<controller::Request>();
    stop->kind = controller::Request::Kind::stop;
    requests.ask(std::move(stop));
  };
  run(for_ever());
  EXPECT_EQ(stops_, 1);
  EXPECT_TRUE(all_are(AxisState::offline));
  EXPECT_LT(turns_, most_turns);
  expect_last_command_is_safe();
}

TEST_F(LiveStage, EndsAtOnceIfAnotherControllerIsActive) {
  on_turn_ = [this] { tester_->send(can::sync_frame(1)); };
  run(for_ever());
  EXPECT_TRUE(controller().keeps_silent());
  EXPECT_LT(turns_, most_turns);
}

TEST_F(LiveStage, SendsTheSafeCommandIfTheRunThrows) {
  LiveRun live = for_ever();
  live.is_done = [this](double) -> bool {
    if (all_are(AxisState::tracking) && output_V(0) > 20.0) throw std::runtime_error("broken");
    return false;
  };
  EXPECT_THROW(run(live), std::runtime_error);
  expect_last_command_is_safe();
}

TEST_F(LiveStage, ClearsALatchedAmplifierFaultOnRequest) {
  latch_faults();
  LiveRun live = until([this] { return turns_ >= 1000; });
  live.clear_faults = true;
  run(live);
  EXPECT_TRUE(tracked_at_stop_);
}

TEST_F(LiveStage, DoesNotClearALatchedAmplifierFaultByDefault) {
  latch_faults();
  run(until([this] { return turns_ >= 1000; }));
  EXPECT_EQ(stops_, 1);
  EXPECT_FALSE(tracked_at_stop_);
}

TEST_F(LiveStage, LogsTheHealthOfTheBus) {
  run(until([this] { return turns_ >= 100; }));
  bus_log_.write();
  EXPECT_FALSE(bus_lines_.empty());
}

bool tell() { return write(STDERR_FILENO, "x", 1) == 1; }

/// Returns the exit status of `work` in a process with its own terminal, which closes after the process has
/// written a byte to standard error; -1 unless the process then writes another byte.
int status_on_terminal(const std::function<int()>& work) {
  int terminal = -1;
  int told[2] = {-1, -1};
  if (pipe(told) != 0) return -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child == 0) {
    std::signal(SIGHUP, [](int) {});
    dup2(told[1], STDERR_FILENO);
    for (const int file : {told[0], told[1]}) close(file);
    const int status = work();
    tell();
    _exit(status);
  }
  close(told[1]);
  char byte = 0;
  if (read(told[0], &byte, 1) != 1) return -1;
  close(terminal);
  if (read(told[0], &byte, 1) != 1) return -1;
  int status = 0;
  waitpid(child, &status, 0);
  return WEXITSTATUS(status);
}

std::ptrdiff_t open_files() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

/// Returns 42 if the terminal has hung up afterwards, but not before.
int hangs_up() {
  if (terminal_hung_up()) return 1;
  const std::ptrdiff_t files = open_files();
  if (terminal_hung_up() || open_files() != files) return 2;
  tell();
  for (char byte = 0; read(STDOUT_FILENO, &byte, 1) > 0;) continue;
  return terminal_hung_up() ? 42 : 43;
}

// The tests run in separate processes, because the first call detects the terminal.
class TerminalHungUp : public testing::Test {
 protected:
  void SetUp() override {
    const int terminal = posix_openpt(O_RDWR);
    if (terminal < 0) GTEST_SKIP() << "this machine has no pseudo-terminals";
    close(terminal);
    GTEST_FLAG_SET(death_test_style, "threadsafe");
  }
};

TEST_F(TerminalHungUp, IsTrueWhenTheTerminalOfTheProcessHasClosed) {
  EXPECT_EXIT(_exit(status_on_terminal(hangs_up)), testing::ExitedWithCode(42), "");
}

TEST_F(TerminalHungUp, IsTrueWithoutStandardInput) {
  const auto work = [] {
    close(STDIN_FILENO);
    return hangs_up();
  };
  EXPECT_EXIT(_exit(status_on_terminal(work)), testing::ExitedWithCode(42), "");
}

TEST_F(TerminalHungUp, IsFalseUnderNohup) {
  const auto work = [] {
    std::signal(SIGHUP, SIG_IGN);
    return hangs_up();
  };
  EXPECT_EXIT(_exit(status_on_terminal(work)), testing::ExitedWithCode(43), "");
}

TEST_F(TerminalHungUp, IsFalseWithoutATerminal) {
  const auto work = [] {
    ioctl(STDIN_FILENO, TIOCNOTTY);
    return hangs_up();
  };
  EXPECT_EXIT(_exit(status_on_terminal(work)), testing::ExitedWithCode(43), "");
}

class StageOnATerminal : public LiveStage {
 public:
  void TestBody() override {}
  /// Returns 42 if the stage ramps down at the hang-up, and later output causes no error.
  int run_until_it_hangs_up() {
    on_turn_ = [this, told = false]() mutable {
      if (!told && all_are(AxisState::tracking)) told = tell();
    };
    run(for_ever());
    if (reloads_ != 0) return 1;
    if (!all_are(AxisState::offline)) return 2;
    return write(STDOUT_FILENO, "x", 1) == 1 ? 42 : 3;
  }
};

TEST_F(TerminalHungUp, EndsARunAndClosesOnlyTheStreamsOfTheTerminal) {
  shows("S-061");
  const auto work = [] { return StageOnATerminal().run_until_it_hangs_up(); };
  EXPECT_EXIT(_exit(status_on_terminal(work)), testing::ExitedWithCode(42), "");
}

void hang_after(milliseconds limit) {
  { const ExitLimit exit_limit(limit); }
  while (true) pause();
}

TEST(ExitLimit, EndsAProcessThatHangsWithOneLineAndStatusOne) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      hang_after(milliseconds(20)), testing::ExitedWithCode(1),
      "hystcan: ended with incomplete files or output, because a disk or a reader of the output did not "
      "respond");
}

TEST(ExitLimit, DoesNotDelayAProcessThatEndsByItself) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto end = [] {
    { const ExitLimit exit_limit(std::chrono::hours(1)); }
    _exit(3);
  };
  EXPECT_EXIT(end(), testing::ExitedWithCode(3), "");
}

}  // namespace
}  // namespace hystcan::app::live_run_test
