// What the controller reports about its own timing, and what it does when it is too late: on the simulated
// bus, under a scheduler that is late by a known time.
#include <gtest/gtest.h>

#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/oversleeper.h"

namespace hystcan::timing_test {
namespace {

using controller::AxisState;
using controller::Cause;
using controller::CycleRecord;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using support::Oversleeper;

class CycleTimingTest : public testing::Test {
 protected:
  explicit CycleTimingTest(can::Duration trip = {})
      : config_(config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml")) {
    config_.controller.wake_up_trip = trip;
    records_.reserve(20'000);
    twin_.emplace(twin_config(config_), config_.database, clock_, [this](std::span<const can::Filter>) {
      return bus_.attach(can::TransmitOrder::by_priority);
    });
    controller_.emplace(
        controller_config(config_), config_.database, sleeper_,
        [this](std::span<const can::Filter>) { return bus_.attach(); },
        [this](const CycleRecord& record) {
          if (records_.size() < records_.capacity()) records_.push_back(record);
        });
    twin_->start();
    controller_->start();
    for (int i = 0; i < 300 && axis().state() != AxisState::tracking; ++i) run_for(milliseconds(10));
    run_for(milliseconds(100));
  }

  void run_for(can::Duration time) { clock_.run_until(clock_.now() + time); }
  const controller::Axis& axis() const { return controller_->axis(0); }
  /// Makes one SYNC late by `late`; the next ones are in time.
  void oversleep_once(can::Duration late) {
    sleeper_.by = late;
    run_for(milliseconds(1));
    sleeper_.by = {};
    run_for(milliseconds(4));
  }

  config::Config config_;
  can::VirtualClock clock_;
  can::SimBus bus_{clock_, 1'000'000};
  Oversleeper sleeper_{clock_};
  std::vector<CycleRecord> records_;
  std::optional<twin::Twin> twin_;
  std::optional<controller::Controller> controller_;
};

TEST_F(CycleTimingTest, HasTheConfiguredPeriodInVirtualTime) {
  ASSERT_EQ(axis().state(), AxisState::tracking);
  const controller::CycleTiming& timing = controller_->timing();
  EXPECT_EQ(timing.period.count(), controller_->counters().cycles - 1);
  EXPECT_EQ(timing.wake_up.count(), controller_->counters().cycles);
  EXPECT_NEAR(timing.period.summary().mean_us, 1000.0, 1e-9);
  EXPECT_NEAR(timing.period.summary().sd_us, 0.0, 1e-9);
  EXPECT_EQ(timing.wake_up.summary().max_us, 0.0);
}

TEST_F(CycleTimingTest, ReportsALateSyncAndItsPeriod) {
  oversleep_once(microseconds(300));
  const controller::CycleTiming& timing = controller_->timing();
  EXPECT_NEAR(timing.wake_up.summary().max_us, 300.0, 1e-9);
  EXPECT_NEAR(timing.period.summary().max_us, 1300.0, 1e-9);
  EXPECT_EQ(axis().state(), AxisState::tracking) << "no trip is configured";
  unsigned late = 0;
  for (const CycleRecord& record : records_) {
    if (record.phases.lateness == can::Duration::zero()) continue;
    ++late;
    EXPECT_EQ(record.phases.lateness, microseconds(300));
    EXPECT_EQ(record.phases.period, microseconds(1300));
  }
  EXPECT_EQ(late, 2u) << "one cycle of two axes";
}

/// The SYNC and the samples of both axes follow one another on the wire: at most 67 us, and 135 us a sample.
TEST_F(CycleTimingTest, ReportsThePhasesOfACycle) {
  const CycleRecord& x = records_[records_.size() - 2];
  const CycleRecord& y = records_.back();
  ASSERT_EQ(x.cycle, y.cycle);
  EXPECT_GT(x.phases.sample_heard, microseconds(100));
  EXPECT_GT(y.phases.sample_heard, x.phases.sample_heard + microseconds(100));
  EXPECT_LT(y.phases.sample_heard, microseconds(67 + 2 * 135 + 50));
  for (const CycleRecord* record : {&x, &y})
    EXPECT_EQ(record->phases.command_sent - record->phases.sample_heard, record->turnaround);
}

class WakeUpTrip : public CycleTimingTest {
 protected:
  WakeUpTrip() : CycleTimingTest(microseconds(400)) {}
};

TEST_F(WakeUpTrip, ToleratesALatenessUpToItsLimit) {
  oversleep_once(microseconds(400));
  EXPECT_EQ(axis().state(), AxisState::tracking);
}

TEST_F(WakeUpTrip, FaultsTheAxesAndSendsTheSafeDriveInTheLateCycle) {
  ASSERT_EQ(axis().state(), AxisState::tracking);
  const std::size_t before = records_.size();
  oversleep_once(microseconds(401));
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_EQ(controller_->axis(i).state(), AxisState::faulted);
    EXPECT_EQ(controller_->axis(i).fault().cause, Cause::cycle_overrun);
  }
  for (std::size_t i = before; i < records_.size(); ++i) {
    const CycleRecord& record = records_[i];
    if (record.phases.lateness == can::Duration::zero()) continue;
    EXPECT_EQ(record.report.state, AxisState::faulted) << "the late cycle itself";
    EXPECT_EQ(record.report.drive, axis().config().gate.safe_drive);
  }
}

}  // namespace
}  // namespace hystcan::timing_test
