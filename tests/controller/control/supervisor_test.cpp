// Each test configures only the limits that it examines: the last allowed value, the first forbidden one, and
// the reset by a good cycle in between. lost_samples_test.cpp tests the bucket of lost samples.
#include "controller/control/supervisor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "controller/control/gate.h"
#include "tests/controller/control/healthy.h"

namespace hystcan::controller::supervisor_test {
namespace {

constexpr double cycle_s = exact_cycle_s;

AxisInput after_cycles(double cycles, double position_um) {
  AxisInput input = sample(position_um);
  input.dt_s = cycles * cycle_s;
  return input;
}

Cause cause_at(double position_um) { return Supervisor(basic_limits()).judge(sample(position_um)).cause; }

TEST(ReferenceTime, StopsWhileTheReferencesWait) {
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

// ---- jumps

Supervisor::Config with_jump_of(double position_jump_um) {
  Supervisor::Config judged = basic_limits();
  judged.position_jump_um = position_jump_um;
  return judged;
}

/// Returns true if a stage at 5 um may be at `position_um` after so many cycles.
bool is_accepted(double position_um, double cycles = 1.0) {
  Supervisor supervisor(with_jump_of(1.0));
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

TEST(PositionJump, IsAllowedOnceInAShortCycle) {
  EXPECT_TRUE(is_accepted(5.9, 0.3));
  EXPECT_FALSE(is_accepted(6.1, 0.3));
}

TEST(PositionJump, IsIgnoredIfItsLimitIsZero) {
  Supervisor supervisor(basic_limits());
  EXPECT_EQ(cycles_until_cause([&](int cycle) { return supervisor.judge(sample(cycle % 2 * 30.0)).cause; }),
            0);
}

TEST(PositionJump, IsJudgedIfItsLimitIsBelowOneMicrometre) {
  Supervisor supervisor(with_jump_of(0.25));
  supervisor.judge(sample(5.0));
  EXPECT_FALSE(supervisor.judge(sample(5.5)).position_um);
}

TEST(PositionJump, IsAllowedOncePerLostCycle) {
  Supervisor supervisor(with_jump_of(1.0));
  supervisor.judge(sample(5.0));
  supervisor.judge(sample({}));
  supervisor.judge(sample({}));
  EXPECT_TRUE(supervisor.judge(sample(7.9)).position_um);
  EXPECT_FALSE(supervisor.judge(sample(9.1)).position_um);
}

TEST(PositionJump, BridgesASpikeButTripsOnALastingJump) {
  Supervisor spiked(with_jump_of(1.0));
  for (int i = 0; i < 1000; ++i) {
    const bool spike = i % 50 == 49;
    const Supervisor::Verdict verdict = spiked.judge(sample(spike ? 9.0 : 5.0));
    ASSERT_EQ(verdict.cause, Cause::none) << i;
    ASSERT_EQ(verdict.position_um.has_value(), !spike);
  }
  Supervisor moved(with_jump_of(1.0));
  moved.judge(sample(5.0));
  Cause cause = Cause::none;
  EXPECT_EQ(cycles_until_cause([&](int) { return cause = moved.judge(sample(20.0)).cause; }), 4);
  EXPECT_EQ(cause, Cause::position_jumped);
}

TEST(PositionJump, AcceptsASecondJumpThatTheDriveExplains) {
  Supervisor supervisor(with_jump_of(1.0));
  supervisor.judge(sample(5.0));
  EXPECT_FALSE(supervisor.judge(sample(13.0), {0.0, 8.0}).position_um);
  EXPECT_FALSE(supervisor.judge(sample(13.0)).position_um);
  EXPECT_TRUE(supervisor.judge(sample(13.5), {0.0, 8.2}).position_um);
  Supervisor at_once(with_jump_of(1.0));
  at_once.judge(sample(5.0));
  EXPECT_FALSE(at_once.judge(sample(13.0), {0.0, 8.0}).position_um);
  EXPECT_TRUE(at_once.judge(sample(13.0), {0.0, 8.0}).position_um);
}

// ---- times

TEST(Stall, BeginsAfterTenCycles) {
  EXPECT_EQ(Supervisor(basic_limits()).judge(after_cycles(10.0, 5.0)).cause, Cause::none);
  EXPECT_EQ(Supervisor(basic_limits()).judge(after_cycles(10.01, 5.0)).cause, Cause::cycle_overrun);
}

TEST(EnableTimeout, IsHalfASecondFromTheFirstEnabledCommand) {
  Supervisor supervisor(basic_limits());
  for (int cycle = 0; cycle < 2000; ++cycle) {
    AxisInput input = sample(5.0);
    input.health.amplifier_enabled = false;
    ASSERT_EQ(supervisor.judge(input).cause, Cause::none) << "not commanded";
    supervisor.watch({.enable = false}, limit::none, cycle_s);
  }
  const int cycles = cycles_until_cause([&](int) {
    AxisInput input = sample(5.0);
    input.health.amplifier_enabled = false;
    const Cause cause = supervisor.judge(input).cause;
    supervisor.watch({.enable = true}, limit::none, cycle_s);
    return cause;
  });
  EXPECT_EQ(cycles, 512 + 2) << "the first cycle that begins more than 512 cycles after the first command";
}

TEST(BusPassive, IsIgnoredIfItsTimeIsZero) {
  Supervisor supervisor(basic_limits());
  AxisInput passive = sample(5.0);
  passive.health.bus_passive = true;
  EXPECT_EQ(cycles_until_cause([&](int) { return supervisor.judge(passive).cause; }), 0);
}

TEST(BusPassive, TripsAfterItsTimeWithoutABreak) {
  Supervisor::Config judged = basic_limits();
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

TEST(Saturated, IsIgnoredIfItsTimeIsZero) {
  Supervisor supervisor(basic_limits());
  EXPECT_EQ(cycles_until_cause([&](int) { return supervisor.watch({}, limit::range, cycle_s); }), 0);
}

TEST(Saturated, TripsOnEveryLastingLimitButNotOnAnInterruptedOne) {
  Supervisor::Config judged = basic_limits();
  judged.saturated_s = 10 * cycle_s;
  for (const std::uint8_t limits : {limit::range, limit::slew, limit::model}) {
    Supervisor lasting(judged);
    Cause cause = Cause::none;
    EXPECT_EQ(cycles_until_cause([&](int) { return cause = lasting.watch({}, limits, cycle_s); }), 11);
    EXPECT_EQ(cause, Cause::saturated);
    Supervisor interrupted(judged);
    EXPECT_EQ(cycles_until_cause([&](int cycle) {
                return interrupted.watch({}, cycle % 11 == 0 ? limit::none : limits, cycle_s);
              }),
              0);
  }
}

TEST(ModelLeftRange, TripsAtTheThirdCycleInARow) {
  for (const std::uint8_t limits : {limit::not_invertible, limit::not_finite}) {
    Supervisor supervisor(basic_limits());
    Cause cause = Cause::none;
    EXPECT_EQ(cycles_until_cause([&](int) { return cause = supervisor.watch({}, limits, cycle_s); }), 3);
    EXPECT_EQ(cause, Cause::model_left_range);
  }
}

TEST(ModelLeftRange, RestartsItsCountAfterEachGoodCycle) {
  for (const std::uint8_t bad : {limit::not_invertible, limit::not_finite}) {
    Supervisor supervisor(basic_limits());
    EXPECT_EQ(cycles_until_cause([&](int cycle) {
                return supervisor.watch({}, cycle % 3 == 0 ? limit::none : bad, cycle_s);
              }),
              0);
  }
}

TEST(ModelLeftRange, IsNotCausedByOtherLimits) {
  Supervisor supervisor(basic_limits());
  constexpr std::uint8_t others = limit::range | limit::slew | limit::model;
  EXPECT_EQ(cycles_until_cause([&](int) { return supervisor.watch({}, others, cycle_s); }), 0);
}

// ---- a frozen position

/// Per cycle: the position, then the drive. Returns the cycle that trips; 0: none.
template <class Position, class Drive>
int cycles_until_frozen(unsigned frozen_cycles, Position position_um, Drive drive) {
  Supervisor::Config judged = basic_limits();
  judged.frozen_cycles = frozen_cycles;
  Supervisor supervisor(judged);
  return cycles_until_cause([&](int cycle) {
    const Cause cause = supervisor.judge(sample(position_um(cycle))).cause;
    supervisor.watch({.drive = drive(cycle), .enable = true}, limit::none, cycle_s);
    return cause;
  });
}

double at_rest(int /*cycle*/) { return 5.0; }

TEST(FrozenPosition, IsIgnoredIfItsCyclesAreZero) {
  EXPECT_EQ(cycles_until_frozen(0, at_rest, [](int cycle) { return 1.0 * cycle; }), 0);
}

TEST(FrozenPosition, IsJudgedOnlyIfTheDriveHasMoved) {
  EXPECT_EQ(cycles_until_frozen(10, at_rest, [](int /*cycle*/) { return 0.0; }), 0)
      << "a quiet sensor at rest";
  EXPECT_EQ(cycles_until_frozen(10, at_rest, [](int cycle) { return 1.0 * cycle; }), 11)
      << "frozen_cycles after the first cycle";
}

TEST(FrozenPosition, MayBeJudgedAfterOneCycle) {
  EXPECT_EQ(cycles_until_frozen(1, at_rest, [](int cycle) { return 10.0 * cycle; }), 2);
}

TEST(FrozenPosition, NeedsMoreThanAFiftiethOfTheDrivesRange) {
  EXPECT_EQ(cycles_until_frozen(2, at_rest, [](int cycle) { return 0.5 * cycle; }), 6) << "2.5 V of 100 V";
}

TEST(FrozenPosition, IsFoundIfTheDriveFalls) {
  EXPECT_EQ(cycles_until_frozen(2, at_rest, [](int cycle) { return -0.5 * cycle; }), 6);
}

TEST(FrozenPosition, StartsAgainAfterEachChangeOfTheLastBit) {
  const auto cycles = [](int cycles_to_a_change) {
    const auto position_um = [=](int cycle) {
      return cycle / cycles_to_a_change % 2 == 0 ? 5.0 : std::nextafter(5.0, 6.0);
    };
    return cycles_until_frozen(10, position_um, [](int cycle) { return 1.0 * cycle; });
  };
  EXPECT_EQ(cycles(10), 0);
  EXPECT_EQ(cycles(11), 21);
}

TEST(FrozenPosition, CountsOnlyTheTravelOfTheDriveSinceItsLastChange) {
  const auto moves = [](int cycle) { return 5.0 + 0.01 * std::min(cycle, 100); };
  EXPECT_EQ(cycles_until_frozen(2, moves, [](int cycle) { return 1.5 * std::min(cycle, 100); }), 0)
      << "the drive moves 1.5 V after the last change, then it rests";
}

// ---- restart and retune

TEST(SupervisorRestart, ResetsTheCountOfLostSamples) {
  Supervisor supervisor(basic_limits());
  for (int i = 0; i < 3; ++i) supervisor.judge(sample({}));
  supervisor.restart();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(supervisor.judge(sample({})).cause, Cause::none);
  EXPECT_NE(supervisor.judge(sample({})).cause, Cause::none);
}

Supervisor::Config bridging(unsigned missing_samples) {
  Supervisor::Config changed = basic_limits();
  changed.missing_samples = missing_samples;
  return changed;
}

TEST(SupervisorRetune, AppliesTheNewNumberOfMissingSamplesAndCountsFromZero) {
  for (const unsigned missing_samples : {1u, 3u, 20u}) {
    Supervisor supervisor(basic_limits());
    for (int i = 0; i < 3; ++i) supervisor.judge(sample({}));
    supervisor.retune(bridging(missing_samples));
    EXPECT_EQ(cycles_until_cause([&](int) { return supervisor.judge(sample({})).cause; }),
              static_cast<int>(missing_samples) + 1);
  }
}

TEST(SupervisorRetune, AppliesTheNewPositionRange) {
  Supervisor supervisor(basic_limits());
  Supervisor::Config wider = basic_limits();
  wider.position_max_um = 60.0;
  supervisor.retune(wider);
  EXPECT_EQ(supervisor.judge(sample(50.0)).cause, Cause::none);
}

TEST(SupervisorRetune, LetsTheTimersContinue) {
  Supervisor::Config judged = basic_limits();
  judged.saturated_s = 10 * cycle_s;
  Supervisor supervisor(judged);
  for (int i = 0; i < 8; ++i) supervisor.watch({}, limit::range, cycle_s);
  supervisor.retune(judged);
  EXPECT_EQ(cycles_until_cause([&](int) { return supervisor.watch({}, limit::range, cycle_s); }), 3);
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

// ---- causes

TEST(Fault, EveryCauseHasItsOwnNameAndRemedy) {
  for (std::size_t i = 1; i < cause_count; ++i) {
    EXPECT_FALSE(remedy(static_cast<Cause>(i)).empty()) << i;
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_NE(to_string(static_cast<Cause>(i)), to_string(static_cast<Cause>(j)));
  }
}

}  // namespace
}  // namespace hystcan::controller::supervisor_test
