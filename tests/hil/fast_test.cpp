// Time in the guest is the number of executed instructions: the tests measure the loop itself, independent of
// the host.
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <boost/asio/io_context.hpp>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "can/socketcan/asio_scheduler.h"
#include "can/socketcan/socketcan_bus.h"
#include "config/schema/config.h"
#include "controller/controller.h"
#include "tests/hil/live_stage.h"

namespace hystcan::fast_test {
namespace {

using controller::AxisState;
using hil::json;
using hil::LiveStage;
using hil::milliseconds;

std::size_t axes_in(const controller::Controller& controller, AxisState state) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < controller.axis_count(); ++i)
    if (controller.axis(i).state() == state) ++count;
  return count;
}

/// Runs the controller in this thread until all axes have tracked for `watched`, or one has faulted.
void run(controller::Controller& controller, boost::asio::io_context& context, can::AsioScheduler& scheduler,
         can::SocketCanBus& bus, can::Duration watched) {
  std::optional<can::Time> until;
  std::unique_ptr<can::Timer> poll;
  poll = scheduler.make_timer([&] {
    const can::Time now = scheduler.now();
    const auto are = [&](AxisState state) { return axes_in(controller, state); };
    if (!until && are(AxisState::tracking) == controller.axis_count()) until = now + watched;
    if (are(AxisState::faulted) != 0) return context.stop();
    if (until && now > *until) return context.stop();
    poll->expire_at(now + milliseconds(20));
  });
  controller.start();
  poll->expire_at(scheduler.now() + milliseconds(20));
  can::run_in_socket(context, scheduler, bus);
}

void use_real_time_priority() {
  const sched_param param{.sched_priority = hil::priority};
  EXPECT_EQ(pthread_setschedparam(pthread_self(), SCHED_FIFO, &param), 0);
}

class IcountFast : public testing::TestWithParam<const char*> {};

// CAN FD frames that axes share. vcan0 has no bit rate: this test measures the loop; AxesThatShareFrames
// measures the wire.
TEST_P(IcountFast, AxesInAFrameMissNoCycleAtTheRateOfTheirFile) {
  const char* asked = std::getenv("HYSTCAN_HIL_FAST_S");
  const int run_s = asked == nullptr ? 1 : std::stoi(asked);
  const std::string file = std::filesystem::path(hil::config_file).replace_filename(GetParam());
  hil::LiveBench bench({"vcan0", "vcan0"}, file);
  bench.candump.reset();  // controller and twin need the only processor
  const config::Config config = config::load(file);
  boost::asio::io_context context{1};
  can::AsioScheduler scheduler(context);
  can::SocketCanBus* bus = nullptr;
  controller::Controller controller(
      controller_config(config), config.database, scheduler,
      [&](std::span<const can::Filter> filters) {
        auto own = std::make_unique<can::SocketCanBus>(context, "vcan0", filters);
        bus = own.get();
        return own;
      },
      [](const controller::CycleRecord&) {});
  std::thread([&] {
    use_real_time_priority();
    run(controller, context, scheduler, *bus, std::chrono::seconds(run_s));
    controller.send_safe_commands();
  }).join();

  const controller::CycleCounters& counters = controller.counters();
  std::printf("%s, %d s: %lu cycles, %lu missed, %lu samples missing, %lu late\n", GetParam(), run_s,
              counters.cycles, counters.missed_cycles, counters.missing_samples, counters.late_samples);
  for (const controller::NamedTime& time : controller::cycle_times())
    std::printf("  %s\n", describe(time.words, (controller.timing().*time.statistics).summary()).c_str());
  EXPECT_EQ(axes_in(controller, AxisState::tracking), controller.axis_count());
  EXPECT_GT(static_cast<double>(counters.cycles), config.controller.rate_Hz * run_s);
  EXPECT_EQ(counters.missed_cycles, 0U);
  EXPECT_EQ(counters.missing_samples, 0U);
  EXPECT_EQ(counters.late_samples, 0U);
}

INSTANTIATE_TEST_SUITE_P(, IcountFast, testing::Values("fd_stage.toml", "fd_eight.toml"),
                         [](const auto& test) { return std::filesystem::path(test.param).stem().string(); });

/// Steps the clock of the guest, which runs only this test. The times in the log step too.
void step_clock(std::time_t seconds) {
  timespec now{};
  ASSERT_EQ(clock_gettime(CLOCK_REALTIME, &now), 0);
  now.tv_sec += seconds;
  ASSERT_EQ(clock_settime(CLOCK_REALTIME, &now), 0);
}

// Deadlines and loop time use the monotonic clock; the kernel stamps frames with the time of day.
TEST(IcountClockStep, DoesNotDisturbTheLoop) {
  LiveStage stage;
  stage.bench.start_controller({"--json"});
  ASSERT_TRUE(stage.bench.tracks()) << stage.bench.controller->err();
  for (const std::time_t step_s : {3600, -3600, -3600, 3600}) {
    std::this_thread::sleep_for(milliseconds(300));
    step_clock(step_s);
  }
  std::this_thread::sleep_for(milliseconds(500));
  EXPECT_EQ(stage.axis_status(0).at("state"), "tracking") << stage.bench.controller->err();
  const json result = stage.bench.stop_and_report(0);
  EXPECT_EQ(result.at("missed_cycles"), 0);
  EXPECT_EQ(result.at("missing_samples"), 0);
  EXPECT_EQ(result.at("late_samples"), 0);
  for (const json& axis : result.at("axes")) EXPECT_LT(axis.at("rms_percent"), 1.0) << axis.dump(2);
  const json& turnaround = result.at("timing").at("turnaround");
  std::printf("turnaround over the steps: p99 %.1f us, max %.1f us\n",
              static_cast<double>(turnaround.at("p99_us")), static_cast<double>(turnaround.at("max_us")));
  EXPECT_LT(turnaround.at("max_us"), 1000.0) << "no stamp is an hour off";
  EXPECT_TRUE(stage.bench.decoded().at("first_fault").is_null());
}

}  // namespace
}  // namespace hystcan::fast_test
