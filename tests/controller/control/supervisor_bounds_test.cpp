// The supervisor at its bounds: the last value that is allowed and the first that is not, and what a good
// cycle in between resets. A cycle of 1/1024 s makes sums of times exact.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "controller/control/gate.h"
#include "controller/control/supervisor.h"
#include "tests/controller/control/healthy.h"
#include "tests/support/shows.h"

namespace hystcan::controller::supervisor_bounds_test {
namespace {

constexpr double cycle_s = 1.0 / 1024.0;

/// Judges only what a test adds to it.
Supervisor::Config config() {
  return {.position_min_um = -3.0,
          .position_max_um = 34.0,
          .position_jump_um = 0.0,
          .missing_samples = 3,
          .frozen_cycles = 0,
          .saturated_s = 0.0,
          .bus_passive_s = 0.0,
          .drive_range = 100.0};
}

AxisInput sample(std::optional<double> position_um) {
  return {
      .time_s = 0.0, .dt_s = cycle_s, .cycle_s = cycle_s, .position_um = position_um, .health = all_is_well};
}

AxisInput late() {
  AxisInput input = sample({});
  input.late_sample = true;
  return input;
}

AxisInput after_cycles(double cycles, double position_um) {
  AxisInput input = sample(position_um);
  input.dt_s = cycles * cycle_s;
  return input;
}

/// The first cycle, counted from 1, in which `step` returns a cause; 0: none of ten thousand cycles.
template <class Step>
int cycles_until_cause(Step step) {
  for (int cycle = 1; cycle <= 10'000; ++cycle)
    if (step(cycle) != Cause::none) return cycle;
  return 0;
}

Cause cause_at(double position_um) { return Supervisor(config()).judge(sample(position_um)).cause; }

TEST(ReferenceTime, StandsStillWhileTheReferencesWait) {
  AxisInput input;
  input.time_s = 3.0;
  input.waited_s = 1.0;
  EXPECT_EQ(input.reference_time_s(), 2.0);
}

TEST(PositionRange, IncludesItsTwoBoundsAndNothingBeyond) {
  EXPECT_EQ(cause_at(-3.0), Cause::none);
  EXPECT_EQ(cause_at(34.0), Cause::none);
  EXPECT_EQ(cause_at(-3.000001), Cause::position_implausible);
  EXPECT_EQ(cause_at(34.000001), Cause::position_implausible);
}

/// Whether a stage at 5 um may be at `position_um` after so many cycles.
bool is_accepted(double position_um, double cycles = 1.0) {
  Supervisor::Config jumps = config();
  jumps.position_jump_um = 1.0;
  Supervisor supervisor(jumps);
  supervisor.judge(sample(5.0));
  return supervisor.judge(after_cycles(cycles, position_um)).position_um.has_value();
}

TEST(PositionJump, IsJudgedInBothDirections) {
  EXPECT_TRUE(is_accepted(6.0)) << "the limit itself";
  EXPECT_TRUE(is_accepted(4.0));
  EXPECT_FALSE(is_accepted(6.001));
  EXPECT_FALSE(is_accepted(3.999));
}

TEST(PositionJump, IsAllowedOncePerWholeCycleRoundedToTheNearest) {
  EXPECT_TRUE(is_accepted(6.9, 2.45));
  EXPECT_FALSE(is_accepted(7.1, 2.45)) << "2.45 cycles are two";
  EXPECT_TRUE(is_accepted(7.9, 2.55)) << "2.55 cycles are three";
  EXPECT_FALSE(is_accepted(8.1, 2.55));
}

TEST(PositionJump, IsAllowedOnceInACycleThatIsShort) {
  EXPECT_TRUE(is_accepted(5.9, 0.3));
  EXPECT_FALSE(is_accepted(6.1, 0.3));
}

TEST(PositionJump, IsNotJudgedWhereItsLimitIsZero) {
  Supervisor supervisor(config());
  EXPECT_EQ(cycles_until_cause([&](int cycle) { return supervisor.judge(sample(cycle % 2 * 30.0)).cause; }),
            0);
}

TEST(PositionJump, IsAlsoJudgedWhereItsLimitIsLessThanOneMicrometre) {
  Supervisor::Config jumps = config();
  jumps.position_jump_um = 0.25;
  Supervisor supervisor(jumps);
  supervisor.judge(sample(5.0));
  EXPECT_FALSE(supervisor.judge(sample(5.5)).position_um);
}

TEST(Stall, BeginsAfterTenCycles) {
  EXPECT_EQ(Supervisor(config()).judge(after_cycles(10.0, 5.0)).cause, Cause::none);
  EXPECT_EQ(Supervisor(config()).judge(after_cycles(10.01, 5.0)).cause, Cause::cycle_overrun);
}

TEST(EnableTimeout, IsHalfASecondFromTheFirstEnabledCommand) {
  Supervisor supervisor(config());
  for (int cycle = 0; cycle < 2000; ++cycle) {
    AxisInput input = sample(5.0);
    input.health.amplifier_enabled = false;
    ASSERT_EQ(supervisor.judge(input).cause, Cause::none) << "not commanded";
    supervisor.judge({.enable = false}, limit::none, cycle_s);
  }
  const int cycles = cycles_until_cause([&](int) {
    AxisInput input = sample(5.0);
    input.health.amplifier_enabled = false;
    const Cause cause = supervisor.judge(input).cause;
    supervisor.judge({.enable = true}, limit::none, cycle_s);
    return cause;
  });
  EXPECT_EQ(cycles, 512 + 2) << "the first cycle that begins more than 512 cycles after the first command";
}

TEST(BusPassive, IsNeverJudgedWhereItsTimeIsZero) {
  Supervisor supervisor(config());
  AxisInput passive = sample(5.0);
  passive.health.bus_passive = true;
  EXPECT_EQ(cycles_until_cause([&](int) { return supervisor.judge(passive).cause; }), 0);
}

TEST(BusPassive, TripsAfterItsTimeWithoutABreak) {
  Supervisor::Config judged = config();
  judged.bus_passive_s = 10 * cycle_s;
  AxisInput passive = sample(5.0);
  passive.health.bus_passive = true;
  Supervisor lasting(judged);
  EXPECT_EQ(cycles_until_cause([&](int) { return lasting.judge(passive).cause; }), 11);
  Supervisor interrupted(judged);
  EXPECT_EQ(cycles_until_cause(
                [&](int cycle) { return interrupted.judge(cycle % 11 == 0 ? sample(5.0) : passive).cause; }),
            0);
}

TEST(Saturated, IsNeverJudgedWhereItsTimeIsZero) {
  Supervisor supervisor(config());
  EXPECT_EQ(cycles_until_cause([&](int) { return supervisor.judge({}, limit::range, cycle_s); }), 0);
}

TEST(Saturated, TripsAfterItsTime) {
  Supervisor::Config judged = config();
  judged.saturated_s = 10 * cycle_s;
  Supervisor supervisor(judged);
  EXPECT_EQ(cycles_until_cause([&](int) { return supervisor.judge({}, limit::range, cycle_s); }), 11);
}

TEST(ModelLeftRange, IsCountedAnewAfterEachGoodCycle) {
  for (const std::uint8_t bad : {limit::not_invertible, limit::not_finite}) {
    Supervisor supervisor(config());
    EXPECT_EQ(cycles_until_cause([&](int cycle) {
                return supervisor.judge({}, cycle % 3 == 0 ? limit::none : bad, cycle_s);
              }),
              0);
  }
}

TEST(ModelLeftRange, IsNotCausedByOtherLimits) {
  Supervisor supervisor(config());
  constexpr std::uint8_t others = limit::range | limit::slew | limit::model;
  EXPECT_EQ(cycles_until_cause([&](int) { return supervisor.judge({}, others, cycle_s); }), 0);
}

// ---- lost samples

/// Loses `losses` samples in a row, then receives `good` ones, for ever. The cycle that trips; 0: none.
int cycles_until_lost(int losses, int good) {
  Supervisor supervisor(config());
  return cycles_until_cause([&](int cycle) {
    return supervisor.judge((cycle - 1) % (losses + good) < losses ? sample({}) : sample(5.0)).cause;
  });
}

TEST(LostSamples, AreCompensatedByTenGoodOnesEach) {
  shows("S-093");
  EXPECT_EQ(cycles_until_lost(1, 10), 0);
  EXPECT_EQ(cycles_until_lost(3, 30), 0);
  EXPECT_EQ(cycles_until_lost(1, 9), 211)
      << "each round leaves a tenth; 21 rounds leave more than two samples";
}

TEST(LostSamples, LeaveNothingBehindAfterThirtyGoodOnes) {
  Supervisor supervisor(config());
  for (int i = 0; i < 3; ++i) supervisor.judge(sample({}));
  for (int i = 0; i < 30; ++i) supervisor.judge(sample(5.0));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(supervisor.judge(sample({})).cause, Cause::none) << i;
  EXPECT_EQ(supervisor.judge(sample({})).cause, Cause::sample_missing);
}

TEST(LostSamples, TripAgainSoonWhereFewGoodOnesCameInBetween) {
  Supervisor supervisor(config());
  for (int i = 0; i < 3; ++i) supervisor.judge(sample({}));
  for (int i = 0; i < 9; ++i) supervisor.judge(sample(5.0));
  EXPECT_EQ(supervisor.judge(sample({})).cause, Cause::sample_missing) << "3 - 0.9 + 1 is more than three";
}

TEST(LostSamples, AreNamedByTheLastRowAlone) {
  const auto after_single_losses = [](const AxisInput& lost, const AxisInput& in_a_row) {
    Supervisor supervisor(config());
    for (int round = 0; round < 20; ++round) {
      supervisor.judge(lost);
      for (int i = 0; i < 10; ++i) supervisor.judge(sample(5.0));
    }
    for (int i = 0; i < 3; ++i) supervisor.judge(in_a_row);
    return supervisor.judge(in_a_row).cause;
  };
  EXPECT_EQ(after_single_losses(sample({}), late()), Cause::sample_late);
  EXPECT_EQ(after_single_losses(late(), sample({})), Cause::sample_missing);
}

TEST(LostSamples, AreMissingWhereHalfOfThemCameLate) {
  Supervisor supervisor(config());
  for (const AxisInput& input : {sample(5.0), late(), late(), sample({})}) supervisor.judge(input);
  EXPECT_EQ(supervisor.judge(sample({})).cause, Cause::sample_missing);
}

TEST(LostSamples, AreACycleOverrunWhereTheCyclesRoundToTwo) {
  for (const double cycles : {1.45, 1.55}) {
    Supervisor supervisor(config());
    AxisInput lost = sample({});
    lost.dt_s = cycles * cycle_s;
    for (int i = 0; i < 3; ++i) supervisor.judge(lost);
    EXPECT_EQ(supervisor.judge(lost).cause, cycles < 1.5 ? Cause::sample_missing : Cause::cycle_overrun);
  }
}

// ---- a frozen position

/// In each cycle: the position, then the drive. The cycle that trips; 0: none.
template <class Position, class Drive>
int cycles_until_frozen(unsigned frozen_cycles, Position position_um, Drive drive) {
  Supervisor::Config judged = config();
  judged.frozen_cycles = frozen_cycles;
  Supervisor supervisor(judged);
  return cycles_until_cause([&](int cycle) {
    const Cause cause = supervisor.judge(sample(position_um(cycle))).cause;
    supervisor.judge({.drive = drive(cycle), .enable = true}, limit::none, cycle_s);
    return cause;
  });
}

double at_rest(int /*cycle*/) { return 5.0; }

TEST(FrozenPosition, IsNeverJudgedWhereItsCyclesAreZero) {
  EXPECT_EQ(cycles_until_frozen(0, at_rest, [](int cycle) { return 1.0 * cycle; }), 0);
}

TEST(FrozenPosition, MayBeJudgedAfterOneCycle) {
  EXPECT_EQ(cycles_until_frozen(1, at_rest, [](int cycle) { return 10.0 * cycle; }), 2);
}

TEST(FrozenPosition, NeedsMoreThanAFiftiethOfTheDrivesRange) {
  EXPECT_EQ(cycles_until_frozen(2, at_rest, [](int cycle) { return 0.5 * cycle; }), 6) << "2.5 V of 100 V";
}

TEST(FrozenPosition, IsAlsoSeenWhereTheDriveFalls) {
  EXPECT_EQ(cycles_until_frozen(2, at_rest, [](int cycle) { return -0.5 * cycle; }), 6);
}

TEST(FrozenPosition, IsCountedAnewAfterEachChange) {
  const auto drive = [](int cycle) { return 1.0 * cycle; };
  EXPECT_EQ(cycles_until_frozen(
                10, [](int cycle) { return 5.0 + 0.001 * (cycle / 10 % 2); }, drive),
            0);
  EXPECT_EQ(cycles_until_frozen(
                10, [](int cycle) { return 5.0 + 0.001 * (cycle / 11 % 2); }, drive),
            21);
}

TEST(FrozenPosition, CountsOnlyTheTravelOfTheDriveSinceItsLastChange) {
  const auto moves = [](int cycle) { return 5.0 + 0.01 * std::min(cycle, 100); };
  EXPECT_EQ(cycles_until_frozen(2, moves, [](int cycle) { return 1.5 * std::min(cycle, 100); }), 0)
      << "the drive moves 1.5 V after the last change, then it rests";
}

// ---- retune

Supervisor::Config bridging(unsigned missing_samples) {
  Supervisor::Config changed = config();
  changed.missing_samples = missing_samples;
  return changed;
}

TEST(SupervisorRetune, AppliesTheNewNumberOfMissingSamplesAndCountsFromZero) {
  for (const unsigned missing_samples : {1u, 3u, 20u}) {
    Supervisor supervisor(config());
    for (int i = 0; i < 3; ++i) supervisor.judge(sample({}));
    supervisor.retune(bridging(missing_samples));
    EXPECT_EQ(cycles_until_cause([&](int) { return supervisor.judge(sample({})).cause; }),
              static_cast<int>(missing_samples) + 1);
  }
}

TEST(SupervisorRetune, AppliesTheNewPositionRange) {
  Supervisor supervisor(config());
  Supervisor::Config wider = config();
  wider.position_max_um = 60.0;
  supervisor.retune(wider);
  EXPECT_EQ(supervisor.judge(sample(50.0)).cause, Cause::none);
}

TEST(SupervisorRetune, LetsTheTimersContinue) {
  Supervisor::Config judged = config();
  judged.saturated_s = 10 * cycle_s;
  Supervisor supervisor(judged);
  for (int i = 0; i < 8; ++i) supervisor.judge({}, limit::range, cycle_s);
  supervisor.retune(judged);
  EXPECT_EQ(cycles_until_cause([&](int) { return supervisor.judge({}, limit::range, cycle_s); }), 3);
}

// ---- the amplifier's statuses

bool is_too_old(double age_s, std::chrono::nanoseconds timeout) {
  NodeHealth health = all_is_well;
  health.status_age_s = age_s;
  return is_status_too_old(health, timeout);
}

TEST(StatusAge, IsJudgedBeyondTheTimeoutAlone) {
  EXPECT_FALSE(is_too_old(0.5, std::chrono::milliseconds(500)));
  EXPECT_TRUE(is_too_old(0.501, std::chrono::milliseconds(500)));
  EXPECT_TRUE(is_too_old(0.001, std::chrono::nanoseconds(1)));
}

TEST(StatusAge, IsNotJudgedWithATimeoutOfZero) { EXPECT_FALSE(is_too_old(1000.0, {})); }

}  // namespace
}  // namespace hystcan::controller::supervisor_bounds_test
