#include "controller/reference/transition.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hystcan::controller::transition_test {
namespace {

double drawn(double lo, double hi) { return lo + (hi - lo) * *rc::gen::inRange(0, 1'000'001) / 1e6; }

struct Peaks {
  double slew = 0.0;
  double acceleration = 0.0;
};

/// By looking at very many points.
Peaks seen(const Transition& way) {
  Peaks peaks;
  constexpr int points = 4000;
  for (int i = 0; i < points; ++i) {
    const Motion at = way.at(way.duration_s() * i / points);
    peaks.slew = std::max(peaks.slew, std::abs(at.velocity_um_per_s));
    peaks.acceleration = std::max(peaks.acceleration, std::abs(at.acceleration_um_per_s2));
  }
  return peaks;
}

TEST(Transition, FromRestIsTheSmoothStep) {
  const Transition way({.value_um = 3.0}, 27.0, 0.2);
  for (const double s : {0.0, 0.1, 0.5, 0.77, 0.999})
    EXPECT_NEAR(way.value_um(0.2 * s), 3.0 + 24.0 * smooth_step(s), 1e-13);
  EXPECT_EQ(way.value_um(0.2), 27.0);
  EXPECT_EQ(way.value_um(9.0), 27.0);
  EXPECT_EQ(way.value_um(-1.0), 3.0);
}

TEST(Transition, FromRestHasTheKnownPeaks) {
  const Transition way({.value_um = 27.0}, 3.0, 0.5);
  EXPECT_NEAR(way.peak_slew_um_per_s(), 1.875 * 24.0 / 0.5, 1e-9);
  EXPECT_NEAR(way.peak_acceleration_um_per_s2(), 10.0 / std::sqrt(3.0) * 24.0 / 0.25, 1e-9);
}

TEST(Transition, IsAsLongAsItsLimitsAskFor) {
  const Motion rest{.value_um = 0.0};
  EXPECT_DOUBLE_EQ(Transition::within({}, rest, 10.0, 0.1).duration_s(), 0.1);
  EXPECT_DOUBLE_EQ(Transition::within({.slew_um_per_s = 1000.0}, rest, 10.0, 0.1).duration_s(), 0.1)
      << "no shorter than asked for";
  EXPECT_DOUBLE_EQ(Transition::within({.slew_um_per_s = 50.0}, rest, 10.0, 0.1).duration_s(), 0.375);
  EXPECT_NEAR(Transition::within({.acceleration_um_per_s2 = 100.0}, rest, -10.0, 0.1).duration_s(),
              std::sqrt(0.57735026919), 1e-9);
  EXPECT_EQ(Transition::within({.slew_um_per_s = 50.0}, rest, 0.0, 0.0).value_um(0.0), 0.0)
      << "no way at all";
}

TEST(TransitionProperty, TellsItsPeaksExactly) {
  EXPECT_TRUE(rc::check("peaks against four thousand points", [] {
    const Motion from{.value_um = drawn(0, 30),
                      .velocity_um_per_s = drawn(-1000, 1000),
                      .acceleration_um_per_s2 = drawn(-1e5, 1e5)};
    const Transition way(from, drawn(0, 30), drawn(0.001, 1.0));
    const Peaks peaks = seen(way);
    RC_ASSERT(peaks.slew <= way.peak_slew_um_per_s() * (1.0 + 1e-9));
    RC_ASSERT(peaks.slew >= way.peak_slew_um_per_s() * (1.0 - 1e-4));
    RC_ASSERT(peaks.acceleration <= way.peak_acceleration_um_per_s2() * (1.0 + 1e-9));
    RC_ASSERT(peaks.acceleration >= way.peak_acceleration_um_per_s2() * (1.0 - 1e-2));  // at an end, steep
  }));
}

TEST(TransitionProperty, KeepsTheLimitsFromEveryMotionWithinThem) {
  EXPECT_TRUE(rc::check("limits, beginning and end", [] {
    const ReferenceLimits limits{.slew_um_per_s = drawn(10, 1000), .acceleration_um_per_s2 = drawn(1e3, 1e6)};
    const Motion from{.value_um = drawn(0, 30),
                      .velocity_um_per_s = limits.slew_um_per_s * drawn(-1, 1),
                      .acceleration_um_per_s2 = limits.acceleration_um_per_s2 * drawn(-1, 1)};
    const double goal_um = drawn(0, 30);
    const Transition way = Transition::within(limits, from, goal_um, 0.0);
    const Peaks peaks = seen(way);
    RC_ASSERT(peaks.slew <= limits.slew_um_per_s * (1.0 + 1e-8));
    RC_ASSERT(peaks.acceleration <= limits.acceleration_um_per_s2 * (1.0 + 1e-8));
    RC_ASSERT(std::abs(way.at(0.0).value_um - from.value_um) <= 1e-12);
    RC_ASSERT(std::abs(way.at(0.0).velocity_um_per_s - from.velocity_um_per_s) <=
              1e-9 * limits.slew_um_per_s);
    const Motion end = way.at(way.duration_s() * (1.0 - 1e-9));
    RC_ASSERT(std::abs(end.value_um - goal_um) <= 1e-6);
    RC_ASSERT(std::abs(end.velocity_um_per_s) <= 1e-6 * limits.slew_um_per_s);
    // No longer than braking to a stand and then going, twice over: it does not merely avoid the question.
    const double speed = std::abs(from.velocity_um_per_s);
    const double braking_s = 1.875 * speed / limits.acceleration_um_per_s2;
    const double distance_um = std::abs(goal_um - from.value_um) + speed * braking_s;
    const double going_s = std::max(1.875 * distance_um / limits.slew_um_per_s,
                                    std::sqrt(5.7735026919 * distance_um / limits.acceleration_um_per_s2));
    RC_ASSERT(way.duration_s() <= 2.0 * (braking_s + going_s) + 1e-3);
  }));
}

TEST(Transition, FromBeyondTheLimitsIsLetDownWithoutGoingFaster) {
  const ReferenceLimits limits{.slew_um_per_s = 100.0, .acceleration_um_per_s2 = 1e4};
  const Transition way = Transition::within(
      limits, {.value_um = 10.0, .velocity_um_per_s = 480.0, .acceleration_um_per_s2 = 1e6}, 20.0, 0.0);
  EXPECT_LE(seen(way).slew, 480.0 * (1.0 + 1e-8));
  EXPECT_LE(seen(way).acceleration, 1e4 * (1.0 + 1e-8));
  EXPECT_EQ(way.value_um(way.duration_s()), 20.0);
}

constexpr model::Interval anywhere{-1000.0, 1000.0};

TEST(TransitionProperty, BrakesFromEveryMotionWithinTheLimitsToAStand) {
  EXPECT_TRUE(rc::check("limits, beginning and end", [] {
    const ReferenceLimits limits{.slew_um_per_s = drawn(10, 1000), .acceleration_um_per_s2 = drawn(1e3, 1e6)};
    const Motion from{.value_um = drawn(0, 30),
                      .velocity_um_per_s = limits.slew_um_per_s * drawn(-1, 1),
                      .acceleration_um_per_s2 = limits.acceleration_um_per_s2 * drawn(-1, 1)};
    const Transition way = Transition::to_stand(limits, from, anywhere);
    const Peaks peaks = seen(way);
    RC_ASSERT(peaks.slew <= limits.slew_um_per_s * (1.0 + 1e-8));
    RC_ASSERT(peaks.acceleration <= limits.acceleration_um_per_s2 * (1.0 + 1e-8));
    RC_ASSERT(std::abs(way.at(0.0).value_um - from.value_um) <= 1e-12);
    RC_ASSERT(std::abs(way.at(0.0).velocity_um_per_s - from.velocity_um_per_s) <=
              1e-9 * limits.slew_um_per_s);
    const Motion end = way.at(way.duration_s() * (1.0 - 1e-9));
    RC_ASSERT(std::abs(end.value_um - way.end_um()) <= 1e-6);
    RC_ASSERT(std::abs(end.velocity_um_per_s) <= 1e-6 * limits.slew_um_per_s);
    // What is still getting faster takes longer: at most the square again of what it has.
    const double braking_s = 1.5 * limits.slew_um_per_s / limits.acceleration_um_per_s2;
    RC_ASSERT(way.duration_s() <= 2.0 * braking_s);
  }));
}

TEST(Transition, BrakesAsHardAsItMayAndHarderWhereThereIsNoRoom) {
  const ReferenceLimits limits{.slew_um_per_s = 3000.0, .acceleration_um_per_s2 = 2.4e5};
  for (const double sign : {1.0, -1.0}) {
    const Motion from{.value_um = 10.0, .velocity_um_per_s = sign * 480.0};
    const Transition free = Transition::to_stand(limits, from, anywhere);
    EXPECT_NEAR(free.duration_s(), 1.5 * 480.0 / 2.4e5, 1e-7);
    EXPECT_NEAR(free.end_um(), 10.0 + sign * 0.72, 1e-4) << "0.75 v^2 / a";
    const Transition hard = Transition::to_stand(limits, from, {9.9, 10.1});
    EXPECT_NEAR(hard.end_um(), 10.0 + sign * 0.1, 1e-12);
    EXPECT_NEAR(hard.duration_s(), 0.2 / 480.0, 1e-12);
    EXPECT_LE(seen(hard).slew, 480.0 * (1.0 + 1e-9));
    const Transition beyond = Transition::to_stand(limits, from, {20.0, 30.0});
    EXPECT_EQ(beyond.duration_s() == 0.0, sign < 0.0) << "not where it would lead further away";
  }
  const Transition corner =
      Transition::to_stand({}, {.value_um = 10.0, .velocity_um_per_s = 480.0}, anywhere);
  EXPECT_EQ(corner.duration_s(), 0.0) << "unlimited";
  EXPECT_EQ(corner.end_um(), 10.0);
}

}  // namespace
}  // namespace hystcan::controller::transition_test
