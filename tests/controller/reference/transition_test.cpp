#include "controller/reference/transition.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>

namespace hystcan::controller::transition_test {
namespace {

double drawn(double lo, double hi) { return lo + (hi - lo) * *rc::gen::inRange(0, 1'000'001) / 1e6; }

struct Peaks {
  double slew = 0.0;
  double acceleration = 0.0;
};

/// Evaluates very many points.
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

TEST(Transition, IsASmoothStepFromRest) {
  const Transition way({.value_um = 3.0}, 27.0, 0.2);
  for (const double s : {0.0, 0.1, 0.5, 0.77, 0.999})
    EXPECT_NEAR(way.value_um(0.2 * s), 3.0 + 24.0 * smooth_step(s), 1e-13);
  EXPECT_EQ(way.value_um(0.2), 27.0);
  EXPECT_EQ(way.value_um(9.0), 27.0);
  EXPECT_EQ(way.value_um(-1.0), 3.0);
}

TEST(Transition, IsAtItsEndIfItHasNoDuration) {
  const Transition way({.value_um = 3.0}, 5.0, 0.0);
  EXPECT_EQ(way.value_um(0.0), 5.0);
  EXPECT_EQ(way.at(0.0).value_um, 5.0);
  EXPECT_EQ(way.at(0.0).velocity_um_per_s, 0.0);
  EXPECT_EQ(way.peak_slew_um_per_s(), 0.0);
  EXPECT_EQ(way.peak_acceleration_um_per_s2(), 0.0);
}

TEST(Transition, IsAsLongAsItsLimitsRequire) {
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

TEST(Transition, KeepsTheRequestedDurationIfTheLimitsAllowLess) {
  const ReferenceLimits wide{.slew_um_per_s = 1e6, .acceleration_um_per_s2 = 1e9};
  for (const double velocity : {100.0, -100.0})
    EXPECT_EQ(
        Transition::within(wide, {.value_um = 1.0, .velocity_um_per_s = velocity}, 10.0, 0.1).duration_s(),
        0.1);
}

// A jump of the acceleration causes a jump of the feed-forward.
TEST(Transition, KeepsTheInitialAccelerationIfTheLimitsAllowIt) {
  const ReferenceLimits limits{.acceleration_um_per_s2 = 2e4};
  for (const double acceleration : {1e4, -1e4, 1.9e4}) {
    const Motion from{.value_um = 1.0, .velocity_um_per_s = 50.0, .acceleration_um_per_s2 = acceleration};
    EXPECT_NEAR(Transition::within(limits, from, 10.0, 0.0).at(0.0).acceleration_um_per_s2, acceleration,
                1e-6);
    const Transition braking = Transition::to_stand(limits, from, {-1000.0, 1000.0});
    const double T = braking.duration_s();
    EXPECT_NEAR(braking.at(0.0).acceleration_um_per_s2, acceleration, 1e-6);
    EXPECT_NEAR(braking.at(0.5 * T).velocity_um_per_s, 0.5 * 50.0 + 0.125 * acceleration * T, 1e-9);
  }
}

// Their accelerations are (1 - s) (1 + s^2), without another zero, and (1 - s) (10 - s) (20 - s) / 200, with
// its other zeros after the end.
TEST(Transition, HasItsPeaksAtTheStartIfItOnlySlowsDown) {
  const Transition without({.velocity_um_per_s = -7.0 / 12.0, .acceleration_um_per_s2 = 1.0}, -13.0 / 60.0,
                           1.0);
  EXPECT_NEAR(without.peak_slew_um_per_s(), 7.0 / 12.0, 1e-12);
  EXPECT_NEAR(without.peak_acceleration_um_per_s2(), 1.0, 1e-12);
  const Transition behind({.velocity_um_per_s = -1141.0 / 2400.0, .acceleration_um_per_s2 = 1.0},
                          -1853.0 / 12000.0, 1.0);
  EXPECT_NEAR(behind.at(0.5).acceleration_um_per_s2, 0.5 * 9.5 * 19.5 / 200.0, 1e-12);
  EXPECT_NEAR(behind.peak_slew_um_per_s(), 1141.0 / 2400.0, 1e-12);
  EXPECT_NEAR(behind.peak_acceleration_um_per_s2(), 1.0, 1e-12);
}

TEST(TransitionProperty, ReportsItsPeaksExactly) {
  EXPECT_TRUE(rc::check("peaks against four thousand points", [] {
    const Motion from{.value_um = drawn(0, 30),
                      .velocity_um_per_s = drawn(-1000, 1000),
                      .acceleration_um_per_s2 = drawn(-1e5, 1e5)};
    const Transition way(from, drawn(0, 30), drawn(0.001, 1.0));
    const Peaks peaks = seen(way);
    RC_ASSERT(peaks.slew <= way.peak_slew_um_per_s() * (1.0 + 1e-9));
    RC_ASSERT(peaks.slew >= way.peak_slew_um_per_s() * (1.0 - 1e-4));
    RC_ASSERT(peaks.acceleration <= way.peak_acceleration_um_per_s2() * (1.0 + 1e-9));
    RC_ASSERT(peaks.acceleration >= way.peak_acceleration_um_per_s2() * (1.0 - 1e-2));  // at a steep end
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
    // At most three times the duration of a stop followed by a motion from rest: the transition is not
    // arbitrarily slow.
    const double speed = std::abs(from.velocity_um_per_s);
    const double braking_s = 1.875 * speed / limits.acceleration_um_per_s2;
    const double distance_um = std::abs(goal_um - from.value_um) + speed * braking_s;
    const double going_s = std::max(1.875 * distance_um / limits.slew_um_per_s,
                                    std::sqrt(5.7735026919 * distance_um / limits.acceleration_um_per_s2));
    RC_ASSERT(way.duration_s() <= 3.0 * (braking_s + going_s) + 1e-3);
  }));
}

TEST(Transition, NeverAcceleratesFromBeyondTheLimits) {
  const ReferenceLimits limits{.slew_um_per_s = 100.0, .acceleration_um_per_s2 = 1e4};
  for (const double sign : {1.0, -1.0}) {
    const Motion from{
        .value_um = 10.0, .velocity_um_per_s = sign * 480.0, .acceleration_um_per_s2 = sign * 1e6};
    const Transition way = Transition::within(limits, from, 10.0 + sign * 10.0, 0.0);
    EXPECT_LE(seen(way).slew, 480.0 * (1.0 + 1e-8));
    EXPECT_LE(seen(way).acceleration, 1e4 * (1.0 + 1e-8));
    EXPECT_EQ(way.value_um(way.duration_s()), 10.0 + sign * 10.0);
    EXPECT_EQ(way.at(0.0).velocity_um_per_s, sign * 480.0);
  }
}

constexpr model::Interval anywhere{-1000.0, 1000.0};

TEST(TransitionProperty, StopsFromEveryMotionWithinTheLimits) {
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
    // A motion that is still accelerating takes longer: at most the square of its values more.
    const double braking_s = 1.5 * limits.slew_um_per_s / limits.acceleration_um_per_s2;
    RC_ASSERT(way.duration_s() <= 2.0 * braking_s);
  }));
}

TEST(Transition, BrakesAtTheLimitAndHarderIfThereIsNoSpace) {
  const ReferenceLimits limits{.slew_um_per_s = 3000.0, .acceleration_um_per_s2 = 2.4e5};
  for (const double sign : {1.0, -1.0}) {
    const Motion from{.value_um = 10.0, .velocity_um_per_s = sign * 480.0};
    const Transition free = Transition::to_stand(limits, from, anywhere);
    EXPECT_NEAR(free.duration_s(), 1.5 * 480.0 / 2.4e5, 1e-7);
    EXPECT_NEAR(free.end_um(), 10.0 + sign * 0.72, 1e-4) << "0.75 v^2 / a";
    const Transition faster =
        Transition::to_stand({.slew_um_per_s = 100.0, .acceleration_um_per_s2 = 2.4e5}, from, anywhere);
    EXPECT_EQ(faster.duration_s(), free.duration_s()) << "beyond the limit of velocity as well";
    const Transition hard = Transition::to_stand(limits, from, {9.9, 10.1});
    EXPECT_NEAR(hard.end_um(), 10.0 + sign * 0.1, 1e-12);
    EXPECT_NEAR(hard.duration_s(), 0.2 / 480.0, 1e-12);
    EXPECT_LE(seen(hard).slew, 480.0 * (1.0 + 1e-9));
    const Transition beyond = Transition::to_stand(limits, from, {20.0, 30.0});
    EXPECT_EQ(beyond.duration_s() == 0.0, sign < 0.0) << "not where it would lead further away";
  }
  const Transition slow = Transition::to_stand({.acceleration_um_per_s2 = 0.5},
                                               {.value_um = 10.0, .velocity_um_per_s = 0.5}, {0.0, 10.1});
  EXPECT_NEAR(slow.end_um(), 10.1, 1e-12);
  const Transition turning =
      Transition::to_stand(limits, {.value_um = 31.0, .acceleration_um_per_s2 = -1e5}, {0.0, 28.0});
  EXPECT_EQ(turning.duration_s(), 0.0) << "at the peak of what is out of the range";
  EXPECT_EQ(turning.end_um(), 31.0);
  const Transition corner =
      Transition::to_stand({}, {.value_um = 10.0, .velocity_um_per_s = 480.0}, anywhere);
  EXPECT_EQ(corner.duration_s(), 0.0) << "unlimited";
  EXPECT_EQ(corner.end_um(), 10.0);
}

TEST(Handover, MatchesItsReportedMotionAlongItsLead) {
  Handover::Lead lead{};
  for (std::size_t i = 0; i < lead.size(); ++i) lead[i] = 1.0 + 0.25 * static_cast<double>(i * i);
  const Handover handover(lead, 0.5, {}, Transition({.value_um = lead.back()}, 3.0, 0.25));
  EXPECT_EQ(handover.value_um(0.0), 1.0);
  EXPECT_EQ(handover.value_um(0.25), lead[16]);
  EXPECT_EQ(handover.value_um(16.5 / 64.0), 0.5 * (lead[16] + lead[17]));
  EXPECT_EQ(handover.at(16.5 / 64.0).velocity_um_per_s, (lead[17] - lead[16]) * 64.0);
  EXPECT_EQ(handover.value_um(0.5), lead.back());
  EXPECT_EQ(handover.value_um(0.75), 3.0);
}

}  // namespace
}  // namespace hystcan::controller::transition_test
