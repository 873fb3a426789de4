// The controller's report about its own timing, and its reaction when it is late: on the simulated bus, with
// a scheduler that is late by a known time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/oversleeper.h"
#include "tests/support/shows.h"

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
  explicit CycleTimingTest(can::Duration trip = {}, const std::vector<model::Coupling>& of_y = {})
      : config_(config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml")) {
    config_.controller.lateness_trip = trip;
    config_.axes[1].control.couplings = of_y;
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
  std::vector<CycleRecord> records_of(std::size_t axis) const {
    std::vector<CycleRecord> records;
    std::ranges::copy_if(records_, std::back_inserter(records), [&](const CycleRecord& record) {
      return record.axis == axis && record.report.state == AxisState::tracking;
    });
    return records;
  }
  /// Delays one SYNC by `late`; the next ones are on time.
  void oversleep_once(can::Duration late) {
    sleeper_.by = late;
    run_for(milliseconds(1));
    sleeper_.by = {};
    run_for(milliseconds(4));
  }

  config::Config config_;
  can::VirtualClock clock_;
  can::SimBus bus_{clock_, {1'000'000}};
  Oversleeper sleeper_{clock_};
  std::vector<CycleRecord> records_;
  std::optional<twin::Twin> twin_;
  std::optional<controller::Controller> controller_;
};

TEST_F(CycleTimingTest, HasTheConfiguredPeriodInVirtualTime) {
  shows("S-149");
  ASSERT_EQ(axis().state(), AxisState::tracking);
  const controller::CycleTiming& timing = controller_->timing();
  EXPECT_EQ(timing.period.count(), controller_->counters().cycles - 1);
  EXPECT_EQ(timing.lateness.count(), controller_->counters().cycles);
  EXPECT_NEAR(timing.period.summary().mean_us, 1000.0, 1e-9);
  EXPECT_NEAR(timing.period.summary().sd_us, 0.0, 1e-9);
  EXPECT_EQ(timing.lateness.summary().max_us, 0.0);
  EXPECT_EQ(controller_->counters().missed_cycles, 0u);
}

TEST_F(CycleTimingTest, ReportsALateSyncAndItsPeriod) {
  oversleep_once(microseconds(300));
  const controller::CycleTiming& timing = controller_->timing();
  EXPECT_NEAR(timing.lateness.summary().max_us, 300.0, 1e-9);
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

/// The SYNC and the samples of both axes follow one another on the wire: at most 67 us, plus 135 us per
/// sample.
TEST_F(CycleTimingTest, ReportsThePhasesOfACycle) {
  const CycleRecord& x = records_[records_.size() - 2];
  const CycleRecord& y = records_.back();
  ASSERT_EQ(x.cycle, y.cycle);
  EXPECT_GT(x.phases.sample_heard, microseconds(100));
  EXPECT_GT(y.phases.sample_heard, x.phases.sample_heard + microseconds(100));
  EXPECT_LT(y.phases.sample_heard, microseconds(67 + 2 * 135 + 50));
  for (const CycleRecord* record : {&x, &y})
    EXPECT_EQ(record->phases.command_sent - record->phases.sample_heard, record->phases.turnaround());
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

// ---- references wait for SYNCs that are left out

/// Returns the largest change from one SYNC to the next.
double largest_step(const std::vector<CycleRecord>& records, auto value) {
  double largest = 0.0;
  for (std::size_t i = 1; i < records.size(); ++i)
    largest = std::max(largest, std::abs(value(records[i]) - value(records[i - 1])));
  return largest;
}
double drive_of(const CycleRecord& record) { return record.report.drive; }

/// Axis x follows a triangle of 24 um at 10 Hz, up to 3 V per cycle; axis y follows a sine.
class StallTest : public CycleTimingTest {
 protected:
  explicit StallTest(const std::vector<model::Coupling>& of_y = {}) : CycleTimingTest({}, of_y) {
    run_for(milliseconds(200));
    records_.clear();
    run_for(milliseconds(100));
    in_time_ = records_of(0);
    records_.clear();
  }
  /// Causes one stall of each length, each at another phase of the triangle.
  void stall_often() {
    for (can::Duration late = milliseconds(3); late <= microseconds(5500); late += microseconds(250)) {
      oversleep_once(late);
      run_for(milliseconds(57));
    }
    ASSERT_EQ(axis().state(), AxisState::tracking);
  }

  std::vector<CycleRecord> in_time_;  ///< records of a period of axis x without a stall
};

TEST_F(StallTest, CausesNoLargerSetpointStepThanUsual) {
  shows("S-046");
  stall_often();
  const double usual_V = largest_step(in_time_, drive_of), after_V = largest_step(records_of(0), drive_of);
  EXPECT_LT(after_V, usual_V + 0.2) << "0.2 V: PI, of an error of 0.3 um. It was 16 V";
}

/// Returns the total lateness of those SYNCs up to record `last` that were late by more than half a cycle.
double waited_s(const std::vector<CycleRecord>& records, std::size_t last) {
  can::Duration waited{};
  for (std::size_t i = 0; i <= last; ++i)
    if (const can::Duration late = records[i].phases.lateness; late > microseconds(500)) waited += late;
  return can::seconds(waited);
}

TEST_F(StallTest, DelaysTheReferencesOfBothAxesByItsLength) {
  stall_often();
  for (const std::size_t axis : {0u, 1u}) {
    const auto reference_at = [&](double time_s) {
      return controller_->axis(axis).reference_at(time_s -
                                                  controller_->axis(axis).config().delays.sensor_s());
    };
    const std::vector<CycleRecord> records = records_of(axis);
    for (std::size_t i = 0; i < records.size(); ++i) {
      const auto point = reference_at(records[i].time_s - waited_s(records, i));
      ASSERT_TRUE(point);
      ASSERT_NEAR(records[i].report.reference_um, point->value_um, 1e-9) << "axis " << axis << ", " << i;
    }
  }
}

TEST_F(StallTest, IsCountedInMissedCycles) {
  for (int i = 0; i < 2; ++i) {
    oversleep_once(microseconds(4300));
    run_for(milliseconds(10));
  }
  EXPECT_EQ(controller_->counters().missed_cycles, 9u) << "8.6 cycles";
}

TEST_F(StallTest, IsFollowedByASyncOneCycleLater) {
  for (can::Duration late = microseconds(501); late <= milliseconds(6); late += microseconds(100)) {
    records_.clear();
    oversleep_once(late);
    run_for(milliseconds(10));
    const std::vector<CycleRecord> records = records_of(0);
    const auto is_late = [](const CycleRecord& record) { return record.phases.period > milliseconds(1); };
    const auto stalled = std::ranges::find_if(records, is_late);
    ASSERT_NE(stalled, records.end());
    EXPECT_EQ(stalled->phases.period, milliseconds(1) + late);
    EXPECT_EQ(std::find_if(std::next(stalled), records.end(), is_late), records.end());
    EXPECT_EQ(std::next(stalled)->phases.period, milliseconds(1));
  }
}

TEST_F(StallTest, DelaysNoReferenceIfAtMostHalfACycle) {
  oversleep_once(microseconds(500));
  std::mt19937 random(1);
  for (int i = 0; i < 500; ++i) {
    sleeper_.by = microseconds(random() % 501);
    run_for(milliseconds(1));
  }
  const std::vector<CycleRecord> records = records_of(0);
  EXPECT_EQ(waited_s(records, records.size() - 1), 0.0);
  EXPECT_EQ(controller_->counters().missed_cycles, 0u);
  EXPECT_EQ(axis().state(), AxisState::tracking);
}

TEST_F(StallTest, KeepsHalfACycleBetweenTwoSyncs) {
  shows("S-091");
  std::mt19937 random(2);
  for (int i = 0; i < 500; ++i) {
    sleeper_.by = microseconds(random() % 1501);
    run_for(milliseconds(1));
  }
  can::Duration shortest = milliseconds(1);
  for (const CycleRecord& record : records_) shortest = std::min(shortest, record.phases.period);
  EXPECT_GE(shortest, microseconds(500));
}

TEST_F(StallTest, DoesNotDelayTheReferenceOfALaterStart) {
  oversleep_once(milliseconds(4));
  for (const std::size_t i : {0u, 1u}) controller_->axis(i).stop();
  run_for(milliseconds(500));
  ASSERT_EQ(axis().state(), AxisState::offline);
  records_.clear();
  for (const std::size_t i : {0u, 1u}) controller_->axis(i).start(false);
  for (int i = 0; i < 1000 && axis().state() != AxisState::tracking; ++i) run_for(milliseconds(1));
  const std::vector<CycleRecord> records = records_of(0);
  ASSERT_FALSE(records.empty());
  const double begin_s = records[0].time_s - 4e-3;
  EXPECT_FALSE(axis().reference_at(begin_s - 1e-6));
  EXPECT_TRUE(axis().reference_at(begin_s + 1e-9));
}

/// In axis y's configuration, a twentieth of the motion of x adds to the motion of y.
class CoupledStallTest : public StallTest {
 protected:
  CoupledStallTest() : StallTest({{.from = "x", .um_per_um = 0.05, .index = 0}}) {}
};

TEST_F(CoupledStallTest, DelaysTheFeedForwardOfTheOtherAxisToo) {
  const auto fed_forward_um = [](const CycleRecord& record) { return record.report.previewed_um; };
  run_for(milliseconds(200));
  const double usual_um = largest_step(records_of(1), fed_forward_um);
  stall_often();
  EXPECT_LT(largest_step(records_of(1), fed_forward_um), usual_um + 0.01);
}

}  // namespace
}  // namespace hystcan::timing_test
