// The raster of a scan: the motion of its two axes, and its reported place.
#include "controller/reference/raster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "controller/reference/shape.h"
#include "controller/reference/trajectory.h"
#include "tests/support/refusal.h"

namespace hystcan::controller::raster_test {
namespace {

/// Lines of 50 ms, turnarounds of 10 ms: 4 lines and 2 for the return.
Raster both_ways(ScanRole role) {
  return {.role = role,
          .low_um = 2.0,
          .high_um = 11.0,
          .line_rate_Hz = 20.0,
          .lines = 4,
          .return_lines = 2,
          .frames = 3,
          .pixels = 10,
          .turnaround_percent = 20.0,
          .mode_period_s = 2e-3};
}

Raster one_way(ScanRole role) {
  Raster raster = both_ways(role);
  raster.both_directions = false;
  raster.flyback_percent = 20.0;
  return raster;
}

std::string refusal(Raster raster) {
  return support::refusal_of<std::invalid_argument>([&] { prepare(raster); });
}

TEST(Raster, LastsEquallyLongOnBothAxes) {
  for (const auto make : {both_ways, one_way}) {
    EXPECT_DOUBLE_EQ(duration_s(prepared(make(ScanRole::fast))), 3 * 6 * 0.05);
    EXPECT_DOUBLE_EQ(duration_s(prepared(make(ScanRole::slow))), 3 * 6 * 0.05);
  }
}

TEST(FastAxis, ScansUpInEvenLinesAndDownInOddOnes) {
  const Shape fast = prepared(both_ways(ScanRole::fast));
  for (int line = 0; line <= 18; ++line)
    EXPECT_NEAR(value_um(fast, 0.05 * line), line % 2 == 0 ? 2.0 : 11.0, 1e-9) << line;
  EXPECT_NEAR(value_um(fast, 0.025), 6.5, 1e-9);
}

TEST(FastAxis, ScansInOneDirectionAndFliesBackInItsShare) {
  const auto raster = std::get<Raster>(prepared(one_way(ScanRole::fast)));
  for (int line = 0; line <= 18; ++line) {
    EXPECT_NEAR(motion_of(raster, 0.05 * line).value_um, 2.0, 1e-9) << line;
    EXPECT_NEAR(motion_of(raster, 0.05 * line + raster.way_up_s).value_um, 11.0, line == 18 ? 10.0 : 1e-9)
        << line;
  }
  const double ratio =
      -motion_of(raster, 0.045).velocity_um_per_s / motion_of(raster, 0.02).velocity_um_per_s;
  EXPECT_NEAR(ratio, 4.0, 1e-9) << "back within 20 % of the line";
}

TEST(SlowAxis, RestsOnEveryLineAndMovesInTheTurnarounds) {
  const Shape slow = prepared(both_ways(ScanRole::slow));
  for (int frame = 0; frame < 3; ++frame)
    for (int line = 0; line < 4; ++line)
      for (const double t_s : {0.0051, 0.025, 0.0449})
        EXPECT_NEAR(value_um(slow, 0.3 * frame + 0.05 * line + t_s), 2.0 + 3.0 * line, 1e-9);
  EXPECT_NEAR(value_um(slow, 0.05), 3.5, 1e-9) << "half-way between two lines";
  EXPECT_TRUE(rests(slow, 0.025));
  EXPECT_FALSE(rests(slow, 0.05));
}

TEST(SlowAxis, MovesDuringTheFlyback) {
  const auto slow = std::get<Raster>(prepared(one_way(ScanRole::slow)));
  for (int line = 0; line < 3; ++line) {
    const double begins_s = 0.05 * line + slow.way_up_s;
    EXPECT_NEAR(motion_of(slow, begins_s - 1e-4).value_um, 2.0 + 3.0 * line, 1e-9);
    EXPECT_NE(motion_of(slow, begins_s + 1e-4).value_um, 2.0 + 3.0 * line);
    EXPECT_NEAR(motion_of(slow, 0.05 * (line + 1)).value_um, 5.0 + 3.0 * line, 1e-9);
  }
}

TEST(SlowAxis, ReturnsToTheFirstLineAtTheEndOfEachFrame) {
  for (const auto make : {both_ways, one_way}) {
    const Shape slow = prepared(make(ScanRole::slow));
    for (int frame = 1; frame <= 3; ++frame) EXPECT_NEAR(value_um(slow, 0.3 * frame), 2.0, 1e-9);
  }
}

TEST(SlowAxis, RisesEvenlyOnARamp) {
  Raster ramp = both_ways(ScanRole::slow);
  ramp.slow = SlowMotion::ramp;
  const Shape slow = prepared(ramp);
  const double speed_um_per_s = motion(slow, 0.1).velocity_um_per_s;
  EXPECT_NEAR(speed_um_per_s, 9.0 / 0.2, 3.0);
  for (const double t_s : {0.01, 0.03, 0.07, 0.19})
    EXPECT_NEAR(motion(slow, t_s).velocity_um_per_s, speed_um_per_s, 1e-9) << t_s;
  EXPECT_LT(motion(slow, 0.25).velocity_um_per_s, 0.0);
}

TEST(SlowAxis, StepsAtOnceInTheCycleOfALineWithoutATurnaround) {
  Raster sharp = both_ways(ScanRole::slow);
  sharp.turnaround_percent = 0.0;
  const Shape slow = prepared(sharp);
  for (int line = 0; line < 4; ++line) {
    const double rounded_s = std::nextafter(0.05 * line, 0.0);
    EXPECT_EQ(value_um(slow, rounded_s), 2.0 + 3.0 * line) << line;
  }
}

TEST(ScanPlace, IsTheSameOnBothAxes) {
  const Shape fast = prepared(one_way(ScanRole::fast));
  const Shape slow = prepared(one_way(ScanRole::slow));
  for (double t_s = 0.0; t_s < 0.95; t_s += 1e-3) {
    const auto one = place_in_scan(fast, t_s);
    const auto other = place_in_scan(slow, t_s);
    ASSERT_EQ(one.has_value(), other.has_value()) << t_s;
    if (!one) continue;
    EXPECT_EQ(one->frame, other->frame) << t_s;
    EXPECT_EQ(one->line, other->line) << t_s;
    EXPECT_EQ(one->pixel, other->pixel) << t_s;
  }
}

TEST(ScanPlace, BeginsALineInTheCycleInWhichItBegins) {
  const Shape fast = prepared(both_ways(ScanRole::fast));
  for (int n = 0; n < 18; ++n) {
    const auto place = place_in_scan(fast, std::nextafter(0.05 * n, 0.0));
    ASSERT_EQ(place.has_value(), n % 6 < 4) << n << ": there is none during the return";
    if (!place) continue;
    EXPECT_EQ(place->frame, static_cast<unsigned>(n / 6));
    EXPECT_EQ(place->line, static_cast<unsigned>(n % 6));
  }
  EXPECT_FALSE(place_in_scan(fast, 0.9)) << "after the last frame";
  EXPECT_FALSE(place_in_scan(Hold{}, 0.5));
}

TEST(ScanPlace, HasAPixelInEveryCycleWithoutATurnaround) {
  Raster sharp = both_ways(ScanRole::fast);
  sharp.turnaround_percent = 0.0;
  const auto fast = std::get<Raster>(prepared(sharp));
  EXPECT_EQ(place_of(fast, 0.0)->pixel, 0);
  EXPECT_EQ(place_of(fast, 0.05)->pixel, 9);
  EXPECT_EQ(place_of(fast, 0.1 - 1e-4)->pixel, 0);
}

// The cycle times are sums: 0.4 + 0.6 need not equal 1.
TEST(ScanPlace, BeginsWithTheFirstCycleAfterTheTransition) {
  for (const double transition_s : {0.1, 0.2, 0.3, 0.7}) {
    Trajectory reference({{.shape = prepared(both_ways(ScanRole::fast)), .transition_s = transition_s}},
                         false);
    reference.start_from(0.0);
    const double begins_s = reference.length_s() - 0.9;
    const auto first = reference.at(std::nextafter(begins_s, 0.0));
    EXPECT_FALSE(first.in_transition) << transition_s;
    ASSERT_TRUE(first.scan) << transition_s;
    EXPECT_EQ(first.scan->line, 0u);
  }
}

TEST(ScanPlace, CountsThePixelsFromTheLowEndInBothDirections) {
  const auto fast = std::get<Raster>(prepared(both_ways(ScanRole::fast)));
  for (int line = 0; line < 4; ++line)
    for (int i = 0; i < 500; ++i) {
      const double t_s = 0.05 * line + (i + 0.5) * 1e-4;
      const auto place = place_of(fast, t_s);
      ASSERT_TRUE(place);
      const bool straight = i >= 50 && i < 450;
      EXPECT_EQ(place->pixel != ScanPlace::no_pixel, straight) << i;
      if (!straight) continue;
      const int along = (i - 50) / 40;
      EXPECT_EQ(place->pixel, line % 2 == 0 ? along : 9 - along) << i;
    }
}

TEST(Raster, RefusesNumbersThatContradictEachOther) {
  Raster raster = both_ways(ScanRole::fast);
  raster.return_lines = 1;
  EXPECT_EQ(
      refusal(raster),
      "lines + return_lines is 5, expected an even number: otherwise, with both_directions, every second "
      "frame starts at the other end of the line");
  raster = one_way(ScanRole::fast);
  raster.flyback_percent = 8.0;
  EXPECT_EQ(
      refusal(raster),
      "turnaround_percent is 20, expected at most 16: half of the turnaround must fit into the trace and "
      "into the flyback of 8 %");
}

}  // namespace
}  // namespace hystcan::controller::raster_test
