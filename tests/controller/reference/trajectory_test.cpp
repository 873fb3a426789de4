#include "controller/reference/trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace hystcan::controller::trajectory_test {
namespace {

TEST(Triangle, RisesAndFallsWithinEachCycle) {
  const Shape triangle = Triangle{.low_um = 3.0, .high_um = 27.0, .frequency_Hz = 10.0, .cycles = 2.0};
  EXPECT_DOUBLE_EQ(duration_s(triangle), 0.2);
  EXPECT_DOUBLE_EQ(value_um(triangle, 0.0), 3.0);
  EXPECT_DOUBLE_EQ(value_um(triangle, 0.025), 15.0);
  EXPECT_DOUBLE_EQ(value_um(triangle, 0.05), 27.0);
  EXPECT_NEAR(value_um(triangle, 0.175), 15.0, 1e-12);
  EXPECT_DOUBLE_EQ(value_um(triangle, 0.2), 3.0);
  EXPECT_DOUBLE_EQ(value_um(triangle, 5.0), 3.0) << "held after the last cycle";
}

TEST(Sine, StartsAtItsLowestWithoutAJumpInVelocity) {
  const Shape sine = Sine{.low_um = 5.0, .high_um = 25.0, .frequency_Hz = 5.0, .cycles = 1.0};
  EXPECT_DOUBLE_EQ(value_um(sine, 0.0), 5.0);
  EXPECT_DOUBLE_EQ(value_um(sine, 0.1), 25.0);
  EXPECT_NEAR(value_um(sine, 1e-6), 5.0, 1e-6);
}

TEST(Staircase, RisesSmoothlyToEachLevelAndDwells) {
  const Shape stairs = Staircase{.levels_um = {10.0, 20.0, 5.0}, .rise_s = 0.1, .dwell_s = 0.2};
  EXPECT_DOUBLE_EQ(duration_s(stairs), 0.9);
  EXPECT_DOUBLE_EQ(value_um(stairs, 0.05), 10.0);
  EXPECT_NEAR(value_um(stairs, 0.35), 15.0, 1e-12) << "half-way up";
  EXPECT_DOUBLE_EQ(value_um(stairs, 0.5), 20.0);
  EXPECT_DOUBLE_EQ(value_um(stairs, 10.0), 5.0);
}

TEST(Staircase, JumpsToEachLevelWithoutARise) {
  const Shape stairs = Staircase{.levels_um = {10.0, 20.0}, .rise_s = 0.0, .dwell_s = 0.2};
  EXPECT_DOUBLE_EQ(value_um(stairs, 0.199), 10.0);
  EXPECT_DOUBLE_EQ(value_um(stairs, 0.2), 20.0);
}

/// Joins while a triangle of 10 Hz runs. Its transition of 0.1 s is too short for 25 um within the limits.
struct Joined {
  static constexpr double at_s = 0.73, start_um = 2.0;
  static Trajectory made() {
    return {{{.shape = Triangle{.low_um = 3, .high_um = 27, .frequency_Hz = 10, .cycles = 100}}},
            true,
            {.slew_um_per_s = 200.0}};
  }
  Trajectory alone = made(), trajectory = made();
  Joined() {
    alone.start_from(start_um);
    trajectory.join(at_s, start_um);
  }
};

TEST(TrajectoryThatJoins, StaysBetweenItsStartAndTheSegments) {
  const Joined joined;
  EXPECT_NEAR(joined.trajectory.value_um(Joined::at_s), Joined::start_um, 1e-12);
  EXPECT_NEAR(joined.trajectory.motion(Joined::at_s).velocity_um_per_s, 0.0, 1e-9) << "it begins at rest";
  for (double t_s = Joined::at_s; t_s < 2.0; t_s += 1e-4) {
    const double now_um = joined.trajectory.value_um(t_s);
    EXPECT_GE(now_um, Joined::start_um);
    EXPECT_LE(now_um, joined.alone.value_um(t_s));
  }
}

TEST(TrajectoryThatJoins, FollowsTheSegmentsInTimeAfterItsTransition) {
  const Joined joined;
  const double whole_s = 1.875 * 25.0 / 200.0;  // for the largest distance, 2 um to 27 um
  const double nearly_s = Joined::at_s + 0.99 * whole_s;
  EXPECT_TRUE(joined.trajectory.at(nearly_s).in_transition);
  EXPECT_NEAR(joined.trajectory.value_um(nearly_s), joined.alone.value_um(nearly_s), 1e-3);
  for (double t_s = Joined::at_s + 1.01 * whole_s; t_s < 2.0; t_s += 1e-3) {
    EXPECT_EQ(joined.trajectory.value_um(t_s), joined.alone.value_um(t_s));
    EXPECT_FALSE(joined.trajectory.at(t_s).in_transition);
  }
}

TEST(TrajectoryThatJoins, TakesAsLongFromAboveAsFromBelow) {
  Trajectory trajectory = Joined::made();
  trajectory.join(Joined::at_s, 28.0);
  const double whole_s = 1.875 * 25.0 / 200.0;  // down to 3 um
  EXPECT_TRUE(trajectory.at(Joined::at_s + 0.99 * whole_s).in_transition);
  EXPECT_FALSE(trajectory.at(Joined::at_s + 1.01 * whole_s).in_transition);
}

TEST(TrajectoryThatJoins, MatchesItsReportedMotion) {
  Trajectory trajectory(
      {{.shape = Sine{.low_um = 3, .high_um = 27, .frequency_Hz = 10, .cycles = 100}, .transition_s = 0.3}},
      true);
  trajectory.join(Joined::at_s, Joined::start_um);
  constexpr double h = 1e-5;
  for (double t_s = Joined::at_s + 0.0013; t_s < 1.2; t_s += 0.0031) {
    const Motion motion = trajectory.motion(t_s);
    const double before_um = trajectory.value_um(t_s - h), after_um = trajectory.value_um(t_s + h);
    EXPECT_EQ(motion.value_um, trajectory.value_um(t_s));
    EXPECT_NEAR(motion.velocity_um_per_s, (after_um - before_um) / (2.0 * h), 1e-3) << t_s;
    EXPECT_NEAR(motion.acceleration_um_per_s2, (after_um - 2.0 * motion.value_um + before_um) / (h * h), 5.0)
        << t_s;
  }
}

TEST(TrajectoryThatJoins, IsInATransitionAndNotInALineOrAtRest) {
  const Raster raster{.role = ScanRole::slow, .high_um = 10.0, .line_rate_Hz = 10.0, .lines = 100};
  Trajectory trajectory({{.shape = raster, .transition_s = 0.3}}, true);
  trajectory.start_from(5.0);
  ASSERT_TRUE(trajectory.at(0.751).at_rest && trajectory.at(0.751).scan) << "on the level of a line";
  trajectory.join(0.73, 5.0);
  const Trajectory::Point point = trajectory.at(0.751);
  EXPECT_TRUE(point.in_transition);
  EXPECT_FALSE(point.at_rest);
  EXPECT_FALSE(point.scan);
  EXPECT_EQ(point.value_um, trajectory.value_um(0.751));
  EXPECT_EQ(point.ideal_um, point.value_um);
}

TEST(TrajectoryThatJoins, ContinuesAReferenceThatWasResumed) {
  Trajectory undisturbed = Joined::made();
  undisturbed.start_from(Joined::start_um);
  undisturbed.resume(0.517, 1e-3);
  Trajectory trajectory = undisturbed;
  trajectory.join(0.73, Joined::start_um, true);
  for (double t_s = 1.2; t_s < 2.0; t_s += 1e-3)
    EXPECT_EQ(trajectory.value_um(t_s), undisturbed.value_um(t_s)) << t_s;
}

TEST(TrajectoryThatJoins, LeavesALiveGoal) {
  Trajectory trajectory = Joined::made();
  trajectory.start_from(Joined::start_um);
  trajectory.go_to(0.3, 20.0);
  trajectory.join(0.73, Joined::start_um, true);
  EXPECT_FALSE(trajectory.at(1.5).live);
}

TEST(TrajectoryThatJoins, DropsTheJoinWhenOtherSegmentsContinue) {
  Joined joined;
  Trajectory fresh = Joined::made();
  fresh.continue_from(joined.trajectory, 0.75);
  joined.trajectory.resume(0.75);
  for (double t_s = 0.75; t_s < 1.5; t_s += 1e-3)
    EXPECT_EQ(joined.trajectory.value_um(t_s), fresh.value_um(t_s)) << t_s;
}

// An earlier version stayed at the start position until the join time, and then jumped into the segments.
TEST(TrajectoryThatJoins, DropsTheJoinWhenTheSegmentsRestart) {
  Joined joined;
  joined.trajectory.join(0.0, Joined::start_um);
  for (double t_s = 0.0; t_s < 2.0; t_s += 1e-3) {
    EXPECT_EQ(joined.trajectory.value_um(t_s), joined.alone.value_um(t_s)) << t_s;
    EXPECT_EQ(joined.trajectory.motion(t_s).velocity_um_per_s, joined.alone.motion(t_s).velocity_um_per_s);
  }
}

// A sample of the first cycles precedes the reference by the delay of its sensor.
TEST(Trajectory, IsAtItsStartBeforeItBegins) {
  Trajectory trajectory = Joined::made();
  trajectory.join(0.0, 14.0);
  EXPECT_EQ(trajectory.at(-0.005).value_um, 14.0);
}

TEST(Trajectory, StartsAtZeroByDefault) {
  const Trajectory trajectory({{.shape = Hold{.level_um = 10.0}, .transition_s = 0.5}}, false);
  EXPECT_EQ(trajectory.value_um(0.0), 0.0);
  EXPECT_TRUE(trajectory.at(0.499).in_transition);
}

/// Two holds of 1 s, with transitions of 0.5 s.
Trajectory two_holds() {
  return {{{.shape = Hold{.level_um = 1, .duration_s = 1}, .transition_s = 0.5},
           {.shape = Hold{.level_um = 2, .duration_s = 1}, .transition_s = 0.5}},
          true};
}

TEST(Trajectory, HasTheLengthOfAPassAndTheStartOfEachSegment) {
  EXPECT_DOUBLE_EQ(two_holds().pass_s(), 3.0);
  EXPECT_EQ(two_holds().begins_s(0), 0.0);
  EXPECT_DOUBLE_EQ(two_holds().begins_s(1), 1.5);
  EXPECT_EQ(Trajectory({}, true).pass_s(), 0.0);
}

// The cycle times are sums and differences: their rounding is 1e-9 s.
TEST(Trajectory, IsInThePartThatBeginsWithinTheRoundingOfATime) {
  const Trajectory trajectory = two_holds();
  const auto is = [&](double t_s, std::size_t segment, bool in_transition) {
    const Trajectory::Point point = trajectory.at(t_s);
    EXPECT_EQ(point.segment, segment) << t_s;
    EXPECT_EQ(point.in_transition, in_transition) << t_s;
  };
  for (const double pass_s : {0.0, 3.0}) {
    is(pass_s + 0.5 - 5e-10, 0, false);
    is(pass_s + 1.5 - 5e-10, 1, true);
    is(pass_s + 2.0 - 5e-10, 1, false);
    is(pass_s + 3.0 - 5e-10, 0, true);
    is(pass_s + 0.5 - 2e-9, 0, true);
    is(pass_s + 1.5 - 2e-9, 0, false);
    is(pass_s + 2.0 - 2e-9, 1, true);
    is(pass_s + 3.0 - 2e-9, 1, false);
  }
}

TEST(Trajectory, DiffersFromItsIdealOnlyInATurnaround) {
  const Shape shape = prepared(
      Triangle{.low_um = 3, .high_um = 27, .frequency_Hz = 10, .cycles = 2, .turnaround_percent = 20});
  Trajectory trajectory({{.shape = shape, .transition_s = 0.25}}, false);
  double most_um = 0.0;
  for (double t_s = 0.0; t_s < 0.5; t_s += 1e-3) {
    const Trajectory::Point point = trajectory.at(t_s);
    EXPECT_EQ(point.ideal_um,
              point.in_transition || point.finished ? point.value_um : ideal_um(shape, point.shape_time_s));
    most_um = std::max(most_um, std::abs(point.ideal_um - point.value_um));
  }
  EXPECT_GT(most_um, 0.1);
}

TEST(Trajectory, RestartsAtItsFirstValue) {
  const std::vector<Segment> ramp{
      {.shape = Ramp{.from_um = 1.0, .to_um = 9.0, .duration_s = 2.0}, .transition_s = 0.25}};
  Trajectory trajectory(ramp, false);
  const Trajectory undisturbed = trajectory;
  trajectory.resume(1.0);
  EXPECT_NEAR(trajectory.value_um(1.2499), 1.0, 1e-3);
  EXPECT_EQ(trajectory.value_um(1.25), 1.0);
  EXPECT_EQ(trajectory.value_um(2.25), 5.0);
  trajectory.start_from(0.0);
  for (const double t_s : {0.1, 0.3, 1.0, 3.0})
    EXPECT_EQ(trajectory.value_um(t_s), undisturbed.value_um(t_s)) << "from t = 0 again";
}

TEST(SmoothStep, HasNoVelocityAtItsEnds) {
  EXPECT_EQ(smooth_step(-1.0), 0.0);
  EXPECT_EQ(smooth_step(2.0), 1.0);
  EXPECT_DOUBLE_EQ(smooth_step(0.5), 0.5);
  EXPECT_LT(smooth_step(1e-4) / 1e-4, 1e-6);
  EXPECT_LT((1.0 - smooth_step(1.0 - 1e-4)) / 1e-4, 1e-6);
}

}  // namespace
}  // namespace hystcan::controller::trajectory_test
