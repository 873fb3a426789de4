// Transitions within limits, and live goals.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "controller/reference/trajectory.h"
#include "tests/support/count_allocations.h"

namespace hystcan::controller::live_goal_test {
namespace {

double drawn(double lo, double hi) { return lo + (hi - lo) * *rc::gen::inRange(0, 1'000'001) / 1e6; }

/// Smooth shapes only; each one is within 700 um/s and 1e5 um/s^2.
std::vector<Segment> smooth_segments() {
  return {{.shape = Sine{.low_um = 5.0, .high_um = 25.0, .frequency_Hz = 10.0, .cycles = 2.0},
           .transition_s = 0.02},
          {.shape = Staircase{.levels_um = {20.0, 10.0, 12.0}, .rise_s = 0.05, .dwell_s = 0.03},
           .transition_s = 0.02},
          {.shape = MultiSine{.centre_um = 15.0,
                              .amplitudes_um = {1.0, 1.0, 1.0},
                              .frequencies_Hz = {5.0, 12.0, 31.0},
                              .duration_s = 0.3},
           .transition_s = 0.02},
          {.shape = Hold{.level_um = 8.0, .duration_s = 0.1}, .transition_s = 0.02}};
}

constexpr ReferenceLimits limits{.slew_um_per_s = 700.0, .acceleration_um_per_s2 = 1e5};

/// Checks in [from, to) that the velocity keeps the slew limit and its changes keep the acceleration limit.
void expect_smooth(const Trajectory& trajectory, double from_s, double to_s) {
  constexpr double dt_s = 1e-4;
  const auto steps = static_cast<int>((to_s - from_s) / dt_s);
  double before_um = trajectory.value_um(from_s);
  double velocity = trajectory.motion(from_s).velocity_um_per_s;
  double fastest = 0.0;
  double hardest = 0.0;
  for (int i = 1; i < steps; ++i) {
    const double now_um = trajectory.value_um(from_s + i * dt_s);
    const double mean_velocity = (now_um - before_um) / dt_s;
    fastest = std::max(fastest, std::abs(mean_velocity));
    // Mean velocities of neighbouring steps differ by at most the acceleration of one step.
    hardest = std::max(hardest, std::abs(mean_velocity - velocity) / dt_s);
    before_um = now_um;
    velocity = mean_velocity;
  }
  RC_ASSERT(fastest <= limits.slew_um_per_s * (1.0 + 1e-6));
  RC_ASSERT(hardest <= limits.acceleration_um_per_s2 * (1.0 + 1e-6));
}

TEST(TrajectoryProperty, KeepsTheLimitsFromEveryStart) {
  EXPECT_TRUE(rc::check("two passes", [] {
    Trajectory trajectory(smooth_segments(), true, limits);
    trajectory.start_from(drawn(0.0, 30.0));
    expect_smooth(trajectory, 0.0, 2.2 * trajectory.length_s());
  }));
}

TEST(TrajectoryProperty, KeepsTheLimitsToAGoalAndBackFromEveryMotion) {
  EXPECT_TRUE(rc::check("go_to, another go_to on its way, resume", [] {
    Trajectory trajectory(smooth_segments(), true, limits);
    trajectory.start_from(drawn(0.0, 30.0));
    double t_s = drawn(0.0, 2.0 * trajectory.length_s());
    for (int goal = 0; goal < 2; ++goal) {
      const Motion before = trajectory.motion(t_s);
      const double goal_um = drawn(0.0, 30.0);
      trajectory.go_to(t_s, goal_um);
      RC_ASSERT(std::abs(trajectory.value_um(t_s) - before.value_um) <= 1e-9);
      RC_ASSERT(std::abs(trajectory.motion(t_s).velocity_um_per_s - before.velocity_um_per_s) <= 1e-6);
      expect_smooth(trajectory, t_s, t_s + 0.5);
      const Trajectory::Point there = trajectory.at(t_s + 10.0);
      RC_ASSERT(there.value_um == goal_um);
      RC_ASSERT(there.live && there.at_rest && !there.in_transition && !there.finished);
      t_s += drawn(0.0, 0.3);
    }
    const Motion before = trajectory.motion(t_s);
    trajectory.resume(t_s);
    RC_ASSERT(std::abs(trajectory.value_um(t_s) - before.value_um) <= 1e-9);
    RC_ASSERT(trajectory.at(t_s).segment == 0u && trajectory.at(t_s).in_transition);
    expect_smooth(trajectory, t_s, t_s + 1.5 * trajectory.length_s());
  }));
}

TEST(Trajectory, LengthensTransitionsUntilTheyKeepTheLimits) {
  Trajectory trajectory({{.shape = Hold{.level_um = 20.0, .duration_s = 1.0}, .transition_s = 0.1},
                         {.shape = Hold{.level_um = 10.0, .duration_s = 1.0}, .transition_s = 0.1}},
                        true, {.slew_um_per_s = 37.5});
  trajectory.start_from(0.0);  // 1.875 * 20 um / 37.5 um/s = 1 s, then 0.5 s, and 0.5 s to restart
  EXPECT_DOUBLE_EQ(trajectory.length_s(), 1.0 + 1.0 + 0.5 + 1.0);
  EXPECT_TRUE(trajectory.at(0.999).in_transition);
  EXPECT_DOUBLE_EQ(trajectory.value_um(0.5), 10.0);
  EXPECT_FALSE(trajectory.at(1.001).in_transition);
  EXPECT_TRUE(trajectory.at(2.499).in_transition);
  EXPECT_EQ(trajectory.at(2.501).segment, 1u);
  EXPECT_FALSE(trajectory.at(2.501).in_transition);
  EXPECT_DOUBLE_EQ(trajectory.value_um(3.75), 15.0) << "half-way into the second pass's first hold";
  EXPECT_EQ(trajectory.at(3.75).segment, 0u);
  EXPECT_NEAR(trajectory.value_um(3.75 + 7 * 3.0), 15.0, 1e-9) << "each further pass is 3 s long";
}

TEST(Trajectory, ReachesAGoalInTheTimeOfTheFirstTransitionWithoutLimits) {
  Trajectory trajectory({{.shape = Hold{.level_um = 10.0, .duration_s = 1.0}, .transition_s = 0.2}}, false);
  trajectory.start_from(10.0);
  trajectory.go_to(0.5, 14.0);
  EXPECT_DOUBLE_EQ(trajectory.value_um(0.6), 12.0);
  EXPECT_TRUE(trajectory.at(0.699).in_transition);
  EXPECT_TRUE(trajectory.at(0.701).at_rest);
  trajectory.resume(5.0);
  EXPECT_NEAR(trajectory.value_um(5.1), 12.0, 1e-9);
  EXPECT_EQ(trajectory.at(5.3).segment, 0u);
  EXPECT_TRUE(trajectory.at(6.3).finished);
}

TEST(Trajectory, LeavesAFastMotionWithoutOvershootIfUnlimited) {
  const std::vector<Segment> segments{
      {.shape = Triangle{.low_um = 3.0, .high_um = 27.0, .frequency_Hz = 10.0, .cycles = 100.0},
       .transition_s = 0.2}};
  Trajectory triangle(segments, false);
  triangle.start_from(3.0);
  const Trajectory before = triangle;
  constexpr double t_s = 0.2 + 0.04;  // at 22.2 um, rising with 480 um/s
  Trajectory next(segments, false);
  next.continue_from(before, t_s);
  triangle.go_to(t_s, 20.0);
  EXPECT_NEAR(triangle.value_um(t_s), 22.2, 1e-9);
  for (int i = 0; i <= 200; ++i) {
    for (const Trajectory* trajectory : {&triangle, &next}) {
      EXPECT_LE(trajectory->value_um(t_s + 1e-3 * i), 22.2 + 1e-9);
      EXPECT_GE(trajectory->value_um(t_s + 1e-3 * i), 3.0 - 1e-9);
    }
  }
}

// A corner of the remaining motion is rounded over a 32nd of the preview.
TEST(Trajectory, DoesNotChangeWithinThePreview) {
  const std::vector<Segment> segments{
      {.shape = Triangle{.low_um = 3.0, .high_um = 27.0, .frequency_Hz = 10.0, .cycles = 100.0},
       .transition_s = 0.2}};
  const TransitionLimits gentle{.motion = {.slew_um_per_s = 3000.0, .acceleration_um_per_s2 = 3e5},
                                .range = {0.0, 28.0}};
  constexpr double preview_s = 2e-3;
  constexpr double rounding_um = 480.0 * preview_s / Handover::lead_intervals;
  Trajectory before(segments, false, {}, gentle);
  before.start_from(3.0);
  for (double t_s = 0.3; t_s < 0.4; t_s += 0.37e-3) {
    Trajectory next(segments, false, {}, gentle);
    next.continue_from(before, t_s, preview_s);
    Trajectory resumed = before;
    resumed.resume(t_s, preview_s);
    Trajectory live = before;
    live.go_to(t_s, 12.0, preview_s);
    for (const Trajectory* trajectory : {&next, &resumed, &live}) {
      EXPECT_TRUE(trajectory->at(t_s).in_transition);
      double last_um = trajectory->value_um(t_s);
      for (int i = 0; i < 300; ++i) {
        const double now_s = t_s + 1e-4 * i;
        const double now_um = trajectory->value_um(now_s);
        const bool previewed = now_s < t_s + preview_s;
        ASSERT_NEAR(now_um, previewed ? before.value_um(now_s) : now_um, rounding_um) << now_s;
        ASSERT_LE(std::abs(now_um - last_um), 480.0 * 1e-4 * (1.0 + 1e-6)) << now_s;
        ASSERT_LE(now_um, 28.0 + 1e-9) << "room to brake in";
        last_um = now_um;
      }
      EXPECT_EQ(trajectory->value_um(t_s + 0.1), trajectory->at(t_s + 0.1).value_um);
    }
  }
}

// Like a streaming client: each goal arrives before the end of the previous goal's preview.
TEST(Trajectory, AcceptsAGoalInEveryCycleWithoutAJump) {
  Trajectory trajectory(smooth_segments(), true, {},
                        {.motion = {.slew_um_per_s = 3000.0, .acceleration_um_per_s2 = 3e5}});
  trajectory.start_from(3.0);
  double last_um = trajectory.value_um(0.1);
  for (int i = 0; i < 400; ++i) {
    const double t_s = 0.1 + 1e-3 * i;
    trajectory.go_to(t_s, 15.0 + 5.0 * std::sin(0.05 * i), 2.7e-3);
    for (int part = 1; part <= 10; ++part) {
      const double now_um = trajectory.value_um(t_s + 1e-4 * part);
      ASSERT_LE(std::abs(now_um - last_um), 700.0 * 1e-4) << i;
      last_um = now_um;
    }
  }
}

TEST(Trajectory, KeepsTheTransitionLimitsBetweenSegments) {
  const std::vector<Segment> segments{
      {.shape = Hold{.level_um = 20.0, .duration_s = 1.0}, .transition_s = 1e-3},
      {.shape = Hold{.level_um = 10.0, .duration_s = 1.0}, .transition_s = 1e-3}};
  Trajectory trajectory(segments, true, {}, {.motion = {.slew_um_per_s = 37.5}});
  trajectory.start_from(0.0);  // 1.875 * 20 um / 37.5 um/s = 1 s, then 0.5 s
  EXPECT_DOUBLE_EQ(trajectory.length_s(), 1.0 + 1.0 + 0.5 + 1.0);
}

TEST(Trajectory, MovesToAGoalAndHoldsItAfterItsSegments) {
  Trajectory trajectory({{.shape = Hold{.level_um = 10.0, .duration_s = 0.1}}}, false);
  trajectory.start_from(10.0);
  EXPECT_TRUE(trajectory.at(100.0).finished);
  trajectory.go_to(100.0, 3.0);
  EXPECT_FALSE(trajectory.at(100.0).finished);
  EXPECT_NEAR(trajectory.value_um(100.05), 6.5, 1e-9);
  EXPECT_EQ(trajectory.value_um(1000.0), 3.0);
  trajectory.start_from(1.0);
  EXPECT_EQ(trajectory.value_um(0.0), 1.0) << "a new start of tracking drops the old goal";
}

TEST(Trajectory, IsAtRestInHoldsDwellsAndAtItsEnd) {
  Trajectory trajectory(
      {{.shape = Hold{.level_um = 10.0, .duration_s = 0.5}, .transition_s = 0.5},
       {.shape = Staircase{.levels_um = {10.0, 12.0}, .rise_s = 0.2, .dwell_s = 0.3}, .transition_s = 0.5},
       {.shape = Step{.from_um = 12.0, .to_um = 13.0, .dwell_s = 0.5}, .transition_s = 0.5},
       {.shape = Ramp{.from_um = 13.0, .to_um = 3.0, .duration_s = 1.0}, .transition_s = 0.5}},
      false);
  trajectory.start_from(0.0);
  for (const double t_s : {0.25, 1.25, 2.1, 2.75, 4.25, 5.2})  // transitions, rise, ramp
    EXPECT_FALSE(trajectory.at(t_s).at_rest) << t_s;
  for (const double t_s : {0.75, 1.75, 2.3, 3.25, 3.75, 6.0})  // hold, dwells, step's levels, end
    EXPECT_TRUE(trajectory.at(t_s).at_rest) << t_s;
}

TEST(Trajectory, CountsTheTimeAtAGoalFromItsArrival) {
  Trajectory trajectory({{.shape = Hold{.level_um = 10.0}, .transition_s = 0.25}}, false);
  trajectory.start_from(10.0);
  trajectory.go_to(0.5, 14.0);
  EXPECT_EQ(trajectory.at(0.625).shape_time_s, 0.0) << "on its way";
  EXPECT_TRUE(trajectory.at(0.75).at_rest);
  EXPECT_EQ(trajectory.at(0.75).shape_time_s, 0.0);
  EXPECT_EQ(trajectory.at(1.75).shape_time_s, 1.0);
}

TEST(Trajectory, LeavesTheMotionAtTheEndOfThePreviewWithoutACorner) {
  Trajectory before(smooth_segments(), true, limits);
  before.start_from(3.0);
  for (double t_s = 0.05; t_s < 0.2; t_s += 7e-3) {
    constexpr double preview_s = 4e-3, h = 1e-6;
    Trajectory live = before;
    live.go_to(t_s, 20.0, preview_s);
    const double turn_s = t_s + preview_s;
    EXPECT_NEAR(live.value_um(turn_s), before.value_um(turn_s), 1e-9);
    EXPECT_NEAR((live.value_um(turn_s + h) - live.value_um(turn_s)) / h,
                before.motion(turn_s).velocity_um_per_s, 1.0)
        << t_s;
  }
}

TEST(Trajectory, HoldsTheEndOfThePreviewIfItHasNoSegments) {
  Trajectory before(smooth_segments(), true, limits);
  before.start_from(3.0);
  Trajectory next({}, true);
  next.continue_from(before, 0.06, 4e-3);
  EXPECT_EQ(next.value_um(0.1), before.value_um(0.064));
}

TEST(Trajectory, HoldsItsStartUntilAGoalIfItHasNoSegments) {
  Trajectory trajectory({}, true);
  trajectory.start_from(7.0);
  EXPECT_EQ(trajectory.value_um(3.0), 7.0);
  trajectory.go_to(3.0, 9.0);
  EXPECT_EQ(trajectory.value_um(4.0), 9.0);
  trajectory.resume(5.0);
  EXPECT_EQ(trajectory.value_um(6.0), 9.0);
}

TEST(Trajectory, AllocatesNothingAfterItsConstruction) {
  Trajectory trajectory(smooth_segments(), true, limits);
  const std::uint64_t before = support::allocations_so_far();
  trajectory.start_from(3.0);
  double sum_um = 0.0;
  for (int i = 0; i < 1000; ++i) {
    sum_um += trajectory.at(3e-3 * i).value_um + trajectory.value_um(3e-3 * i);
    if (i % 100 == 50) trajectory.go_to(3e-3 * i, 0.02 * i);
    if (i % 100 == 99) trajectory.resume(3e-3 * i);
  }
  EXPECT_EQ(support::allocations_so_far(), before);
  EXPECT_GT(sum_um, 0.0);
}

}  // namespace
}  // namespace hystcan::controller::live_goal_test
