// The control thread on real SocketCAN allocates nothing, locks nothing, logs nothing and opens no file: the
// same controller as in `hystcan controller`, in this process, under the trap of tests/support.
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <memory>
#include <optional>
#include <thread>

#include "can/bus_health_log.h"
#include "can/socketcan/asio_scheduler.h"
#include "can/socketcan/socketcan_bus.h"
#include "config/schema/config.h"
#include "controller/black_box.h"
#include "controller/telemetry.h"
#include "tests/hil/live_bench.h"
#include "tests/support/trap.h"

namespace hystcan::trap_test {
namespace {

using controller::AxisState;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// The controller program without signal handling and report.
class InProcess {
 public:
  InProcess()
      : config_(config::load(hil::config_file)),
        bus_log_("vcan0", [](auto, const std::string&) {}),
        black_box_({.folder = testing::TempDir()}, {"x", "y"}, [](auto, const std::string&) {}),
        csv_(std::filesystem::path(testing::TempDir()) / "trap.csv", {"x", "y"}),
        telemetry_([this](const controller::CycleRecord& record) {
          bus_log_.write();
          black_box_.add(record);
          csv_.write(record);
        }),
        controller_(
            controller_config(config_), config_.database, scheduler_,
            [this](std::span<const can::Filter> filters) {
              auto bus = std::make_unique<can::SocketCanBus>(context_, "vcan0", filters);
              bus_ = bus.get();
              return bus;
            },
            [this](const controller::CycleRecord& record) { telemetry_.push(record); }) {}

  /// Runs until the axes track, plus one second in which Asio may still allocate; then traps the thread for
  /// `watched`.
  void run(can::Duration watched) {
    // The same as hil::with_real_time_priority for a process.
    constexpr sched_param as_the_twin{.sched_priority = hil::priority};
    if (geteuid() == 0) pthread_setschedparam(pthread_self(), SCHED_FIFO, &as_the_twin);
    const can::Time start = scheduler_.now();
    std::unique_ptr<can::Timer> poll;
    poll = scheduler_.make_timer([&] {
      const can::Time now = scheduler_.now();
      bus_log_.sample(can::report_of(controller_.bus(), can::seconds(now - start)));
      advance(now, watched);
      poll->expire_at(now + milliseconds(20));
    });
    controller_.start();
    poll->expire_at(start + milliseconds(20));
    can::run_in_socket(context_, scheduler_, *bus_);
    support::watch(false);
  }

  const std::string& refusal() const { return refusal_; }
  bool was_watched() const { return watching_until_.has_value(); }
  controller::Controller& controller() { return controller_; }

 private:
  void advance(can::Time now, can::Duration watched) {
    if (watching_until_) {
      if (now > *watching_until_) context_.stop();
      return;
    }
    if (controller_.axis(0).state() == AxisState::faulted) context_.stop();  // a faulted axis never tracks
    if (controller_.axis(0).state() != AxisState::tracking) return;
    if (!settled_) settled_ = now + seconds(1);
    if (now < *settled_) return;
    refusal_ = support::trap_this_thread();
    watching_until_ = now + watched;
    support::watch(true);
  }

  config::Config config_;
  boost::asio::io_context context_{1};
  can::AsioScheduler scheduler_{context_};
  can::SocketCanBus* bus_ = nullptr;  ///< of the controller
  can::BusHealthLog bus_log_;
  controller::BlackBox black_box_;
  controller::CsvLog csv_;
  controller::TelemetryThread telemetry_;
  controller::Controller controller_;
  std::optional<can::Time> settled_;
  std::optional<can::Time> watching_until_;
  std::string refusal_;
};

TEST(Trap, ControlThreadOnSocketCanAllocatesLocksLogsAndOpensNothing) {
  hil::LiveBench bench({"vcan0", "vcan0"});
  InProcess program;
  std::thread([&] { program.run(seconds(1)); }).join();
  program.controller().send_safe_commands();
  ASSERT_TRUE(program.was_watched()) << to_string(program.controller().axis(0).fault().cause);
  EXPECT_EQ(program.controller().axis(0).state(), AxisState::tracking)
      << to_string(program.controller().axis(0).fault().cause);
  EXPECT_EQ(support::heap_calls(), 0u);
  EXPECT_EQ(support::trapped_call_count(), 0u) << testing::PrintToString(support::trapped_calls());
  if (!program.refusal().empty()) GTEST_SKIP() << "allocations only: " << program.refusal();
}

}  // namespace
}  // namespace hystcan::trap_test
