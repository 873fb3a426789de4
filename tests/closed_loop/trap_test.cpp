// The control thread allocates nothing, locks nothing, logs nothing and opens no file: it runs under a filter
// that traps all system calls except the few of its event loop, and with a heap that counts calls. This test
// uses the simulated bus, with the real telemetry thread, CSV and black box; tests/hil has the same test on
// SocketCAN.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "config/schema/config.h"
#include "controller/black_box.h"
#include "controller/requests.h"
#include "controller/telemetry.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"
#include "tests/support/scratch.h"
#include "tests/support/trap.h"

namespace hystcan::trap_test {
namespace {

using controller::AxisState;
using std::chrono::milliseconds;
using std::chrono::seconds;

struct Trapped {
  std::string refusal;
  std::uint64_t heap_calls = 0;
  std::uint64_t system_calls = 0;
};

/// Runs `work` on a thread that is trapped and observed.
template <class Work>
Trapped trapped(Work work) {
  const std::uint64_t heap_before = support::heap_calls();
  const std::uint64_t calls_before = support::trapped_call_count();
  Trapped result;
  std::thread([&] {
    result.refusal = support::trap_this_thread();
    support::watch(true);
    work();
    support::watch(false);
  }).join();
  result.heap_calls = support::heap_calls() - heap_before;
  result.system_calls = support::trapped_call_count() - calls_before;
  return result;
}

TEST(Trap, CatchesAnAllocation) {
  const Trapped caught = trapped([] {
    void* volatile memory = std::malloc(100);  // volatile, so that the compiler does not remove both calls
    std::free(memory);
    auto* volatile number = new int(1);
    delete number;
  });
  EXPECT_EQ(caught.heap_calls, 4u);
}

TEST(Trap, CatchesALogLine) {
  const Trapped caught = trapped([] {
    std::fputs("never seen\n", stderr);
    std::fflush(stderr);
  });
  if (!caught.refusal.empty()) GTEST_SKIP() << caught.refusal;
  EXPECT_GE(caught.system_calls, 1u);
}

TEST(Trap, CatchesAFileAndASleep) {
  const Trapped caught = trapped([] {
    const int file = ::open("/dev/null", O_RDONLY);
    if (file >= 0) ::close(file);
    ::usleep(1);
  });
  if (!caught.refusal.empty()) GTEST_SKIP() << caught.refusal;
  EXPECT_EQ(caught.system_calls, 2u);
}

/// A mutex makes this call if another thread owns it.
TEST(Trap, CatchesAWaitForALock) {
  const Trapped caught = trapped([] {
    int word = 1;
    const timespec at_most{.tv_sec = 0, .tv_nsec = 1'000'000};
    ::syscall(SYS_futex, &word, FUTEX_WAIT_PRIVATE, 1, &at_most, nullptr, 0);
  });
  if (!caught.refusal.empty()) GTEST_SKIP() << caught.refusal;
  EXPECT_EQ(caught.system_calls, 1u);
}

/// Covers the start, tracking, a fault of both axes and the time after it. Cycle records take the same path
/// as on real CAN.
TEST(ControlThread, AllocatesLocksLogsAndOpensNothing) {
  const support::ScratchFolder folder;
  Trapped caught;
  {
    controller::BlackBox black_box({.folder = folder.path()}, {"x", "y"}, [](auto, const std::string&) {});
    controller::CsvLog csv(folder / "run.csv", {"x", "y"});
    controller::TelemetryThread telemetry([&](const controller::CycleRecord& record) {
      black_box.add(record);
      csv.write(record);
    });
    rehearsal::Rehearsal loop(support::shipped("piezo.toml"),
                              [&](const controller::CycleRecord& record) { telemetry.push(record); });
    loop.start();
    caught = trapped([&] { loop.run_for(seconds(4)); });
    ASSERT_EQ(loop.controller().axis(0).state(), AxisState::tracking);
    loop.kill_twin();
    const Trapped while_faulting = trapped([&] { loop.run_for(milliseconds(500)); });
    ASSERT_EQ(loop.controller().axis(0).state(), AxisState::faulted);
    caught.heap_calls += while_faulting.heap_calls;
    caught.system_calls += while_faulting.system_calls;
  }
  EXPECT_EQ(caught.heap_calls, 0u);
  EXPECT_EQ(caught.system_calls, 0u) << testing::PrintToString(support::trapped_calls());
  std::size_t black_boxes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    black_boxes += entry.path().filename().string().starts_with("blackbox_") ? 1 : 0;
  EXPECT_EQ(black_boxes, 2u) << "the telemetry thread is not trapped";
  if (!caught.refusal.empty()) GTEST_SKIP() << "allocations only: " << caught.refusal;
}

/// A reload changes the loop; the axis ramps down and arms again.
TEST(ControlThread, AllocatesNothingToCarryOutARequest) {
  using Kind = controller::Request::Kind;
  const rehearsal::Setup setup = support::shipped("piezo.toml");
  controller::RequestLink requests;
  rehearsal::Rehearsal loop(setup, support::ignore);
  loop.controller().listen_to(requests);
  loop.start();
  loop.run_for(seconds(2));
  for (const Kind kind : {Kind::go_to, Kind::resume, Kind::retune, Kind::disable, Kind::enable}) {
    ASSERT_EQ(loop.controller().axis(0).state() == AxisState::tracking, kind != Kind::enable);
    auto request = std::make_unique<controller::Request>();
    request->kind = kind;
    request->position_um = 12.0;
    if (kind == Kind::retune)
      request->tuning = std::make_unique<controller::AxisTuning>(setup.controller.axes[0].axis, true);
    ASSERT_TRUE(requests.ask(std::move(request)));
    const Trapped caught = trapped([&] { loop.run_for(milliseconds(1500)); });
    EXPECT_EQ(caught.heap_calls, 0u) << static_cast<int>(kind);
    const auto answer = requests.take_answer();
    ASSERT_NE(answer, nullptr);
    EXPECT_EQ(answer->refusal, std::nullopt);
  }
  EXPECT_EQ(loop.controller().axis(0).state(), AxisState::tracking);
}

}  // namespace
}  // namespace hystcan::trap_test
