#include "controller/control/supervisor.h"

#include <gtest/gtest.h>

#include "controller/control/following_error.h"
#include "controller/control/gate.h"
#include "tests/controller/control/healthy.h"

namespace hystcan::controller::supervisor_test {
namespace {

constexpr double cycle_s = 1e-3;

Supervisor::Config config() {
  return {.position_min_um = -3.0,
          .position_max_um = 34.0,
          .position_jump_um = 1.0,
          .missing_samples = 3,
          .frozen_cycles = 10,
          .saturated_s = 0.0105,
          .bus_passive_s = 0.0,
          .drive_range = 100.0};
}

AxisInput sample(std::optional<double> position_um) {
  return {
      .time_s = 0.0, .dt_s = cycle_s, .cycle_s = cycle_s, .position_um = position_um, .health = all_is_well};
}

/// The first cycle, counted from 1, in which `step` returns a cause; 0: none of a thousand cycles.
template <class Step>
int cycles_until_cause(Step step) {
  for (int cycle = 1; cycle <= 1000; ++cycle)
    if (step(cycle) != Cause::none) return cycle;
  return 0;
}

TEST(Supervisor, BridgesASingleSpikeAndTripsOnAPositionThatStaysElsewhere) {
  Supervisor spiked(config());
  for (int i = 0; i < 1000; ++i) {
    const bool spike = i % 50 == 49;
    const Supervisor::Verdict verdict = spiked.judge(sample(spike ? 9.0 : 5.0 + 1e-4 * (i % 2)));
    ASSERT_EQ(verdict.cause, Cause::none) << i;
    ASSERT_EQ(verdict.position_um.has_value(), !spike);
  }
  Supervisor moved(config());
  moved.judge(sample(5.0));
  Cause cause = Cause::none;
  EXPECT_EQ(cycles_until_cause([&](int) { return cause = moved.judge(sample(20.0)).cause; }), 4);
  EXPECT_EQ(cause, Cause::position_jumped);
}

TEST(Supervisor, BelievesASecondJumpWhereTheDriveHasMovedTheStageSoFar) {
  Supervisor supervisor(config());
  supervisor.judge(sample(5.0));
  EXPECT_FALSE(supervisor.judge(sample(13.0), {0.0, 8.0}).position_um);
  EXPECT_FALSE(supervisor.judge(sample(13.0)).position_um);
  EXPECT_TRUE(supervisor.judge(sample(13.5), {0.0, 8.2}).position_um);
  Supervisor at_once(config());
  at_once.judge(sample(5.0));
  EXPECT_FALSE(at_once.judge(sample(13.0), {0.0, 8.0}).position_um);
  EXPECT_TRUE(at_once.judge(sample(13.0), {0.0, 8.0}).position_um);
}

TEST(Supervisor, AllowsAJumpForEachLostCycle) {
  Supervisor supervisor(config());
  supervisor.judge(sample(5.0));
  supervisor.judge(sample({}));
  supervisor.judge(sample({}));
  EXPECT_TRUE(supervisor.judge(sample(7.9)).position_um);
  EXPECT_FALSE(supervisor.judge(sample(9.1)).position_um);
}

TEST(Supervisor, AllowsAJumpForEachCycleThatTheSyncIsLate) {
  Supervisor supervisor(config());
  supervisor.judge(sample(5.0));
  AxisInput late = sample(9.0);
  late.dt_s = 4.2 * cycle_s;
  EXPECT_TRUE(supervisor.judge(late).position_um);
  EXPECT_FALSE(supervisor.judge(sample(13.0)).position_um);
}

TEST(Supervisor, ReportsLateSamplesOrMissingOnesByTheGreaterNumber) {
  for (const bool mostly_late : {true, false}) {
    Supervisor supervisor(config());
    Cause cause = Cause::none;
    for (int i = 0; i < 4; ++i) {
      AxisInput input = sample({});
      input.late_sample = mostly_late ? i != 0 : i == 0;
      cause = supervisor.judge(input).cause;
    }
    EXPECT_EQ(cause, mostly_late ? Cause::sample_late : Cause::sample_missing);
  }
}

// A computer that is too slow leaves SYNCs out, and its twin answers none in time.
TEST(Supervisor, ReportsACycleOverrunWhereMostMissingSamplesAreOfCyclesThatWereTooLong) {
  for (const bool mostly_long : {true, false}) {
    Supervisor supervisor(config());
    Cause cause = Cause::none;
    for (int i = 0; i < 4; ++i) {
      AxisInput input = sample({});
      input.dt_s = (mostly_long ? i != 0 : i == 0) ? 4.0 * cycle_s : 1.4 * cycle_s;
      cause = supervisor.judge(input).cause;
    }
    EXPECT_EQ(cause, mostly_long ? Cause::cycle_overrun : Cause::sample_missing);
  }
}

/// The drive rises by this amount in each cycle; the position is constant to the last bit.
int cycles_until_frozen(double drive_per_cycle) {
  Supervisor supervisor(config());
  return cycles_until_cause([&](int cycle) {
    const Cause cause = supervisor.judge(sample(5.0)).cause;
    supervisor.judge({.drive = drive_per_cycle * cycle, .enable = true}, limit::none, cycle_s);
    return cause;
  });
}

TEST(Supervisor, ReportsAFrozenPositionOnlyWhereTheDriveHasMoved) {
  EXPECT_EQ(cycles_until_frozen(0.0), 0) << "a quiet sensor at rest";
  EXPECT_EQ(cycles_until_frozen(1.0), 11) << "frozen_cycles after the first cycle";
  EXPECT_EQ(cycles_until_frozen(0.05), 42) << "after a fiftieth of the drive's range, 2 V";
}

TEST(Supervisor, DoesNotReportAFrozenPositionWhereTheLastBitChanges) {
  Supervisor supervisor(config());
  for (int cycle = 1; cycle < 1000; ++cycle) {
    ASSERT_EQ(supervisor.judge(sample(cycle % 9 == 0 ? 5.0001 : 5.0)).cause, Cause::none);
    supervisor.judge({.drive = 0.1 * cycle, .enable = true}, limit::none, cycle_s);
  }
}

TEST(Supervisor, TripsOnEveryLastingLimitButNotOnAnInterruptedOne) {
  for (const std::uint8_t limits : {limit::range, limit::slew, limit::model}) {
    Supervisor lasting(config());
    Cause cause = Cause::none;
    EXPECT_EQ(cycles_until_cause([&](int) { return cause = lasting.judge({}, limits, cycle_s); }), 11);
    EXPECT_EQ(cause, Cause::saturated);
    Supervisor interrupted(config());
    EXPECT_EQ(cycles_until_cause([&](int cycle) {
                return interrupted.judge({}, cycle % 10 == 0 ? limit::none : limits, cycle_s);
              }),
              0);
  }
}

TEST(Supervisor, TripsWhereTheModelIsNotInvertibleOrTheLawNotFiniteThreeTimesInARow) {
  for (const std::uint8_t limits : {limit::not_invertible, limit::not_finite}) {
    Supervisor supervisor(config());
    Cause cause = Cause::none;
    EXPECT_EQ(cycles_until_cause([&](int) { return cause = supervisor.judge({}, limits, cycle_s); }), 3);
    EXPECT_EQ(cause, Cause::model_left_range);
  }
}

TEST(Supervisor, ResetsEverythingWhenTheAxisStartsAgain) {
  Supervisor supervisor(config());
  for (int i = 0; i < 3; ++i) supervisor.judge(sample({}));
  supervisor.restart();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(supervisor.judge(sample({})).cause, Cause::none);
  EXPECT_NE(supervisor.judge(sample({})).cause, Cause::none);
}

TEST(Fault, EveryCauseHasItsOwnNameAndRemedy) {
  for (std::size_t i = 1; i < cause_count; ++i) {
    EXPECT_FALSE(remedy(static_cast<Cause>(i)).empty()) << i;
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_NE(to_string(static_cast<Cause>(i)), to_string(static_cast<Cause>(j)));
  }
}

TEST(FollowingError, AllowsALagOfAMovingStageAndNoneOfARestingStage) {
  const FollowingError::Config config{.error_um = 1.0, .lag = std::chrono::milliseconds(5), .cycles = 1};
  FollowingError moving(config);
  FollowingError resting(config);
  for (int i = 0; i < 100; ++i) {
    const double reference_um = 1.0 * i;  // 1000 um/s, so that the lag is 5 um
    ASSERT_EQ(moving.step(reference_um, reference_um - 5.9, cycle_s), i != 0)
        << "the first cycle has no slope";
    ASSERT_TRUE(resting.step(50.0, 50.9, cycle_s));
  }
  EXPECT_FALSE(moving.step(100.0, 100.0 - 6.1, cycle_s));
  EXPECT_FALSE(resting.step(50.0, 51.1, cycle_s));
}

TEST(FollowingError, TripsOnlyAfterTheConfiguredCyclesInARow) {
  FollowingError watch({.error_um = 1.0, .lag = {}, .cycles = 3});
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(watch.step(0.0, i % 3 == 2 ? 0.0 : 2.0, cycle_s));
  watch.step(0.0, 2.0, cycle_s);
  EXPECT_TRUE(watch.step(0.0, 2.0, cycle_s));
  EXPECT_FALSE(watch.step(0.0, 2.0, cycle_s));
}

}  // namespace
}  // namespace hystcan::controller::supervisor_test
