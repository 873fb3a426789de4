// Lost samples: the number that the supervisor bridges, and the reported cause.
#include <gtest/gtest.h>

#include "controller/control/supervisor.h"
#include "tests/controller/control/healthy.h"
#include "tests/support/shows.h"

namespace hystcan::controller::lost_samples_test {
namespace {

constexpr double cycle_s = exact_cycle_s;

AxisInput late() {
  AxisInput input = sample({});
  input.late_sample = true;
  return input;
}

/// Loses `losses` samples in a row, then receives `good` samples, repeatedly. Returns the cycle that trips;
/// 0: none.
int cycles_until_lost(int losses, int good) {
  Supervisor supervisor(basic_limits());
  return cycles_until_cause([&](int cycle) {
    return supervisor.judge((cycle - 1) % (losses + good) < losses ? sample({}) : sample(5.0)).cause;
  });
}

TEST(LostSamples, AreCompensatedByTenGoodSamplesEach) {
  shows("S-093");
  EXPECT_EQ(cycles_until_lost(1, 10), 0);
  EXPECT_EQ(cycles_until_lost(3, 30), 0);
  EXPECT_EQ(cycles_until_lost(1, 9), 211)
      << "each round leaves a tenth; 21 rounds leave more than two samples";
}

TEST(LostSamples, AreFullyCompensatedByThirtyGoodSamples) {
  Supervisor supervisor(basic_limits());
  for (int i = 0; i < 3; ++i) supervisor.judge(sample({}));
  for (int i = 0; i < 30; ++i) supervisor.judge(sample(5.0));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(supervisor.judge(sample({})).cause, Cause::none) << i;
  EXPECT_EQ(supervisor.judge(sample({})).cause, Cause::sample_missing);
}

TEST(LostSamples, TripSoonAfterFewGoodSamples) {
  Supervisor supervisor(basic_limits());
  for (int i = 0; i < 3; ++i) supervisor.judge(sample({}));
  for (int i = 0; i < 9; ++i) supervisor.judge(sample(5.0));
  EXPECT_EQ(supervisor.judge(sample({})).cause, Cause::sample_missing) << "3 - 0.9 + 1 is more than three";
}

TEST(LostSamples, AreNamedByTheLastRowAlone) {
  const auto after_single_losses = [](const AxisInput& lost, const AxisInput& in_a_row) {
    Supervisor supervisor(basic_limits());
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

TEST(LostSamples, AreLateOrMissingByTheGreaterNumber) {
  for (const bool mostly_late : {true, false}) {
    Supervisor supervisor(basic_limits());
    Cause cause = Cause::none;
    for (int i = 0; i < 4; ++i) {
      AxisInput input = sample({});
      input.late_sample = mostly_late ? i != 0 : i == 0;
      cause = supervisor.judge(input).cause;
    }
    EXPECT_EQ(cause, mostly_late ? Cause::sample_late : Cause::sample_missing);
  }
}

TEST(LostSamples, AreMissingIfHalfOfThemWereLate) {
  Supervisor supervisor(basic_limits());
  for (const AxisInput& input : {sample(5.0), late(), late(), sample({})}) supervisor.judge(input);
  EXPECT_EQ(supervisor.judge(sample({})).cause, Cause::sample_missing);
}

// A computer that is too slow misses SYNCs, and its twin answers none in time.
TEST(LostSamples, AreACycleOverrunIfMostOfTheirCyclesAreTooLong) {
  for (const bool mostly_long : {true, false}) {
    Supervisor supervisor(basic_limits());
    Cause cause = Cause::none;
    for (int i = 0; i < 4; ++i) {
      AxisInput input = sample({});
      input.dt_s = (mostly_long ? i != 0 : i == 0) ? 4.0 * cycle_s : 1.4 * cycle_s;
      cause = supervisor.judge(input).cause;
    }
    EXPECT_EQ(cause, mostly_long ? Cause::cycle_overrun : Cause::sample_missing);
  }
}

TEST(LostSamples, AreACycleOverrunIfTheCyclesRoundToTwo) {
  for (const double cycles : {1.45, 1.55}) {
    Supervisor supervisor(basic_limits());
    AxisInput lost = sample({});
    lost.dt_s = cycles * cycle_s;
    for (int i = 0; i < 3; ++i) supervisor.judge(lost);
    EXPECT_EQ(supervisor.judge(lost).cause, cycles < 1.5 ? Cause::sample_missing : Cause::cycle_overrun);
  }
}

}  // namespace
}  // namespace hystcan::controller::lost_samples_test
