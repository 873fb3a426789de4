#include "controller/control/following_error.h"

#include <gtest/gtest.h>

#include <optional>

#include "controller/control/loop.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::in_position_test {
namespace {

/// Tolerance 10 nm, window 20 ms, timeout 100 ms; a cycle is 1 ms.
class Judge {
 public:
  Arrival moving(double reference_um) { return step(reference_um, false, 0.0); }
  Arrival resting(std::optional<double> error_um, double reference_um = 15.0) {
    return step(reference_um, true, error_um);
  }
  /// Judges after a cycle of this length.
  Arrival resting_after(double dt_s, double error_um) {
    const Trajectory::Point reference{.value_um = 0.0, .at_rest = true};
    return InPosition::step(config_, state_, reference, -error_um, dt_s);
  }
  Arrival resting_for(int cycles, std::optional<double> error_um, double reference_um = 15.0) {
    Arrival last = Arrival::not_judged;
    for (int i = 0; i < cycles; ++i) last = resting(error_um, reference_um);
    return last;
  }

 private:
  Arrival step(double reference_um, bool rests, std::optional<double> error_um) {
    const Trajectory::Point reference{.value_um = reference_um, .at_rest = rests};
    std::optional<double> position_um;
    if (error_um) position_um = reference_um - *error_um;
    return InPosition::step(config_, state_, reference, position_um, 1e-3);
  }

  InPosition::Config config_{.tolerance_um = 0.01,
                             .window = std::chrono::milliseconds(20),
                             .timeout = std::chrono::milliseconds(100)};
  InPosition::State state_;
};

TEST(InPosition, IsReachedAfterTheWindowWithoutABreak) {
  Judge judge;
  EXPECT_EQ(judge.moving(14.9), Arrival::moving);
  EXPECT_EQ(judge.resting_for(20, 0.005), Arrival::moving) << "19 ms since the first sample within";
  EXPECT_EQ(judge.resting(-0.01), Arrival::in_position) << "20 ms, and just at the tolerance";
}

TEST(InPosition, IsReachedAtTheToleranceOnEitherSide) {
  for (const double error_um : {-0.01, 0.01}) {
    Judge judge;
    EXPECT_EQ(judge.resting_for(21, error_um, 0.0), Arrival::in_position) << error_um;
  }
}

TEST(InPosition, IsNotReachedBeyondTheToleranceOnEitherSide) {
  for (const double error_um : {-0.011, 0.011}) {
    Judge judge;
    EXPECT_EQ(judge.resting_for(50, error_um, 0.0), Arrival::moving) << error_um;
  }
}

TEST(InPosition, AllowsAWindowShorterByUnderANanosecond) {
  const auto after = [](double dt_s) {
    Judge judge;
    judge.resting_after(0.0, 0.0);
    return judge.resting_after(dt_s, 0.0);
  };
  EXPECT_EQ(after(0.02 - 0.9e-9), Arrival::in_position);
  EXPECT_EQ(after(0.02 - 1.1e-9), Arrival::moving);
}

TEST(InPosition, StartsTheWindowAgainAfterABreak) {
  Judge judge;
  EXPECT_EQ(judge.resting_for(20, 0.005), Arrival::moving);
  EXPECT_EQ(judge.resting(0.011), Arrival::moving);
  EXPECT_EQ(judge.resting_for(20, 0.005), Arrival::moving);
  EXPECT_EQ(judge.resting(0.005), Arrival::in_position);
}

TEST(InPosition, IsNotReachedWhileTheReferenceMoves) {
  Judge judge;
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(judge.moving(1e-3 * i), Arrival::moving) << "it never fails";
}

TEST(InPosition, FailsAtTheTimeoutAfterTheReferenceHasStopped) {
  Judge judge;
  EXPECT_EQ(judge.resting_for(100, 0.5), Arrival::moving) << "99 ms";
  EXPECT_EQ(judge.resting(0.5), Arrival::failed) << "100 ms";
  EXPECT_EQ(judge.resting_for(1000, 0.5), Arrival::failed);
}

TEST(InPosition, MayStillBeReachedAfterTheTimeout) {
  Judge judge;
  EXPECT_EQ(judge.resting_for(150, 0.5), Arrival::failed);
  EXPECT_EQ(judge.resting_for(20, 0.0), Arrival::failed);
  EXPECT_EQ(judge.resting(0.0), Arrival::in_position);
}

TEST(InPosition, IsLeftAtOnceAndHasTheFullTimeoutToReturn) {
  Judge judge;
  EXPECT_EQ(judge.resting_for(5000, 0.0), Arrival::in_position);
  EXPECT_EQ(judge.resting(0.02), Arrival::moving);
  EXPECT_EQ(judge.resting_for(99, 0.02), Arrival::moving);
  EXPECT_EQ(judge.resting(0.02), Arrival::failed);
}

TEST(InPosition, IsLeftIfTheReferenceMovesOrJumps) {
  Judge judge;
  EXPECT_EQ(judge.resting_for(30, 0.0), Arrival::in_position);
  EXPECT_EQ(judge.resting(0.0, 16.0), Arrival::moving) << "after a jump the window starts again";
  EXPECT_EQ(judge.resting_for(20, 0.0, 16.0), Arrival::in_position);
  EXPECT_EQ(judge.moving(16.0), Arrival::moving);
}

TEST(InPosition, JudgesNoErrorWithoutASample) {
  Judge judge;
  EXPECT_EQ(judge.resting_for(15, 0.0), Arrival::moving);
  EXPECT_EQ(judge.resting_for(10, std::nullopt), Arrival::moving) << "the window stands still";
  EXPECT_EQ(judge.resting_for(5, 0.0), Arrival::moving);
  EXPECT_EQ(judge.resting(0.0), Arrival::in_position);
  EXPECT_EQ(judge.resting(std::nullopt), Arrival::in_position) << "a missing sample does not end in_position";
  Judge blind;
  EXPECT_EQ(blind.resting_for(101, std::nullopt), Arrival::failed);
}

/// A stage that is always 5 nm below its reference: a transition of 50 ms, then a hold of 1 s.
Arrival arrival_at(double t_s, const std::optional<InPosition::Config>& in_position) {
  AxisConfig axis = support::piezo_axis();
  axis.repeat = false;
  axis.reference_limits = axis.transition_limits = {};
  axis.in_position = in_position;
  axis.following_error = {.error_um = 100.0, .lag = {}, .cycles = 1};
  ClosedLoop loop(axis);
  loop.begin(0.0, 0.0, 0.0);
  const Trajectory reference = [&] {
    Trajectory trajectory(axis.setpoint, false);
    trajectory.start_from(0.0);
    return trajectory;
  }();
  AxisReport report;
  for (int cycle = 0; 1e-3 * cycle <= t_s; ++cycle) {
    const double now_s = 1e-3 * cycle;
    const double position_um = reference.value_um(now_s) - 0.005;
    loop.propose({.dt_s = 1e-3, .cycle_s = 1e-3, .position_um = position_um, .health = {}}, now_s, false,
                 report);
  }
  return report.arrival;
}

TEST(InPositionOfALoop, IsReachedOneWindowAfterTheTransition) {
  constexpr InPosition::Config fine{.tolerance_um = 0.01,
                                    .window = std::chrono::milliseconds(20),
                                    .timeout = std::chrono::milliseconds(100)};
  constexpr InPosition::Config too_fine{.tolerance_um = 0.004,
                                        .window = std::chrono::milliseconds(20),
                                        .timeout = std::chrono::milliseconds(100)};
  EXPECT_EQ(arrival_at(0.0655, fine), Arrival::moving);
  EXPECT_EQ(arrival_at(0.0755, fine), Arrival::in_position);
  EXPECT_EQ(arrival_at(0.1455, too_fine), Arrival::moving);
  EXPECT_EQ(arrival_at(0.1555, too_fine), Arrival::failed);
  EXPECT_EQ(arrival_at(0.5, std::nullopt), Arrival::not_judged);
}

}  // namespace
}  // namespace hystcan::controller::in_position_test
