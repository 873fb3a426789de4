#include "controller/reference/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hystcan::controller::trajectory_test {
namespace {

TEST(Triangle, GoesUpAndBackDownWithinEachCycle) {
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

TEST(Trajectory, IsContinuousFromEveryStartPosition) {
  Trajectory trajectory({{.shape = Triangle{.low_um = 3, .high_um = 27, .frequency_Hz = 10, .cycles = 3}},
                         {.shape = Staircase{.levels_um = {20, 10}, .rise_s = 0.05, .dwell_s = 0.05}}},
                        true);
  trajectory.start_from(14.0);
  constexpr double dt_s = 1e-5;
  double before = 14.0;
  for (double t_s = 0.0; t_s < 2.5 * trajectory.length_s(); t_s += dt_s) {
    const double now = trajectory.at(t_s).value_um;
    ASSERT_NEAR(now, before, 1000.0 * dt_s)
        << "at " << t_s << " s";  // no shape here moves faster than 1000 um/s
    before = now;
  }
}

/// Joined while a triangle of 10 Hz runs. Its transition of 0.1 s is shorter than the limits allow for 25 um.
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

TEST(TrajectoryThatJoins, FollowsTheSegmentsOnTheirOwnTimeAfterATransitionWithinTheLimits) {
  const Joined joined;
  const double whole_s = 1.875 * 25.0 / 200.0;  // of the largest way, 2 um to 27 um
  EXPECT_TRUE(joined.trajectory.at(Joined::at_s + 0.99 * whole_s).in_transition);
  for (double t_s = Joined::at_s + 1.01 * whole_s; t_s < 2.0; t_s += 1e-3) {
    EXPECT_EQ(joined.trajectory.value_um(t_s), joined.alone.value_um(t_s));
    EXPECT_FALSE(joined.trajectory.at(t_s).in_transition);
  }
}

TEST(TrajectoryThatJoins, MovesAsItsMotionSays) {
  const Joined joined;
  constexpr double h = 1e-6;
  for (double t_s = Joined::at_s + 0.0013; t_s < 1.2; t_s += 0.0031) {
    const double slope =
        (joined.trajectory.value_um(t_s + h) - joined.trajectory.value_um(t_s - h)) / (2.0 * h);
    EXPECT_NEAR(joined.trajectory.motion(t_s).velocity_um_per_s, slope, 1e-3);
  }
}

TEST(TrajectoryThatJoins, GoesOnWithAReferenceThatBeganAgainLater) {
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

// Once it stayed at the start of its joining until the time of that, and then jumped into the segments.
TEST(TrajectoryThatJoins, ForgetsItWhereTheSegmentsBeginAnew) {
  Joined joined;
  joined.trajectory.join(0.0, Joined::start_um);
  for (double t_s = 0.0; t_s < 2.0; t_s += 1e-3) {
    EXPECT_EQ(joined.trajectory.value_um(t_s), joined.alone.value_um(t_s)) << t_s;
    EXPECT_EQ(joined.trajectory.motion(t_s).velocity_um_per_s, joined.alone.motion(t_s).velocity_um_per_s);
  }
}

// A sample of the first cycles is older than the reference, by the delay of its sensor.
TEST(Trajectory, WasAtItsStartBeforeItBegan) {
  Trajectory trajectory = Joined::made();
  trajectory.join(0.0, 14.0);
  EXPECT_EQ(trajectory.at(-0.005).value_um, 14.0);
}

TEST(Trajectory, ReportsTheSegmentAndWhenItIsFinished) {
  Trajectory trajectory({{.shape = Hold{.level_um = 1, .duration_s = 1}, .transition_s = 0.5},
                         {.shape = Hold{.level_um = 2, .duration_s = 1}, .transition_s = 0.5}},
                        false);
  trajectory.start_from(0.0);
  EXPECT_TRUE(trajectory.at(0.2).in_transition);
  EXPECT_EQ(trajectory.at(0.7).segment, 0u);
  EXPECT_DOUBLE_EQ(trajectory.at(0.7).shape_time_s, 0.7 - 0.5);
  EXPECT_EQ(trajectory.at(1.7).segment, 1u);
  EXPECT_TRUE(trajectory.at(1.7).in_transition);
  EXPECT_FALSE(trajectory.at(2.9).finished);
  EXPECT_TRUE(trajectory.at(3.1).finished);
  EXPECT_DOUBLE_EQ(trajectory.at(3.1).value_um, 2.0);
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
