// Turnarounds, compared with their definition: the corner averaged with a weight that does not excite one
// mode.
#include "controller/reference/motion.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>

#include "controller/reference/shape.h"

namespace hystcan::controller::turnaround_test {
namespace {

constexpr double mode_s = 2e-3;

/// The remaining ringing of an undamped mode, as a share of that of a sharp corner: |P(2 pi / T_m)|.
double ringing(const Turnaround& turnaround, double period_s = mode_s) {
  constexpr int points = 100'000;
  const double step_s = turnaround.length_s() / points;
  double sum = 0.0;
  for (int i = 0; i < points; ++i) {
    const double t_s = (i + 0.5) * step_s - 0.5 * turnaround.length_s();
    sum += 0.5 * turnaround.curvature_per_s(t_s) * std::cos(2.0 * std::numbers::pi * t_s / period_s) * step_s;
  }
  return std::abs(sum);
}

TEST(Turnaround, DoesNotExciteTheModeBeyondFourSeventhsOfAPeriod) {
  for (const double periods : {0.58, 0.7, 0.99, 1.0, 1.01, 1.37, 2.0, 2.5, 7.77})
    EXPECT_LT(ringing(Turnaround(periods * mode_s, mode_s)), 1e-4) << periods;
}

TEST(Turnaround, LeavesAFifthOfTheRingingAtHalfAPeriod) {
  EXPECT_NEAR(ringing(Turnaround(0.5 * mode_s, mode_s)), 0.194, 0.001);
  EXPECT_NEAR(ringing(Turnaround(0.5 * mode_s, 0.0)), 2.0 / std::numbers::pi, 0.001)
      << "one pulse leaves this";
}

// A resonance 10 % off causes at most a tenth of the ringing if the turnaround is a period or longer.
TEST(Turnaround, ToleratesAResonanceTenPercentOff) {
  for (const double periods : {0.7, 1.0, 1.5, 2.5, 4.0})
    for (const double off : {0.9, 1.1})
      EXPECT_LT(ringing(Turnaround(periods * mode_s, mode_s), off * mode_s), periods < 1.0 ? 0.18 : 0.12)
          << periods << " " << off;
}

TEST(Turnaround, HasTheSlopeAndCurvatureOfItsPath) {
  constexpr double h_s = 1e-8;
  for (const double length_s : {1e-3, 1.5e-3, 2e-3, 2.6e-3, 9e-3}) {
    const Turnaround turnaround(length_s, mode_s);
    for (int i = -55; i <= 55; ++i) {
      const double t_s = length_s * (i + 0.37) / 100.0;
      EXPECT_NEAR((turnaround.way_s(t_s + h_s) - turnaround.way_s(t_s - h_s)) / (2.0 * h_s),
                  turnaround.slope(t_s), 1e-5);
      EXPECT_NEAR((turnaround.slope(t_s + h_s) - turnaround.slope(t_s - h_s)) / (2.0 * h_s),
                  turnaround.curvature_per_s(t_s), 1e-3 * turnaround.peak_curvature_per_s());
    }
  }
}

TEST(Turnaround, IsASharpCornerIfItHasNoLength) {
  const Turnaround none;
  for (const double t_s : {-0.3, 0.0, 0.2}) EXPECT_EQ(none.way_s(t_s), std::abs(t_s));
  EXPECT_EQ(Turnaround(0.0, mode_s).length_s(), 0.0);
}

/// A continuous path: its steps, and those of its velocity, follow from the stated peaks.
void is_smooth(const Sawtooth& wave, double low_um, double high_um) {
  constexpr int points = 4000;
  const double step_s = 1.3 * wave.period_s() / points;
  Motion before = wave.at(0.0);
  for (int i = 1; i <= points; ++i) {
    const Motion now = wave.at(i * step_s);
    RC_ASSERT(now.value_um >= low_um - 1e-9 * (1.0 + std::abs(low_um)));
    RC_ASSERT(now.value_um <= high_um + 1e-9 * (1.0 + std::abs(high_um)));
    RC_ASSERT(std::abs(now.value_um - before.value_um) <=
              1.000001 * wave.peak_slew_um_per_s() * step_s + 1e-9);
    RC_ASSERT(std::abs(now.velocity_um_per_s - before.velocity_um_per_s) <=
              1.000001 * wave.peak_acceleration_um_per_s2() * step_s + 1e-6 * wave.peak_slew_um_per_s());
    before = now;
  }
}

RC_GTEST_PROP(Sawtooth, IsContinuousInValueAndVelocityAndStaysWithinItsEnds, ()) {
  const double low_um = *rc::gen::inRange(-50, 50);
  const double high_um = low_um + *rc::gen::inRange(1, 100);
  const double period_s = 1e-3 * *rc::gen::inRange(10, 2000);
  const double rise_share = 0.01 * *rc::gen::inRange(20, 81);
  const double share = 0.01 * *rc::gen::inRange(1, 21);  // for one turnaround
  const double mode = 1e-4 * *rc::gen::inRange(0, 100);
  is_smooth({low_um, high_um, period_s, rise_share, Turnaround(share * period_s, mode)}, low_um, high_um);
}

RC_GTEST_PROP(Sawtooth, HasItsExtremesAndIsPeriodic, ()) {
  const double period_s = 1e-3 * *rc::gen::inRange(10, 2000);
  const double rise_share = 0.01 * *rc::gen::inRange(20, 81);
  const double share = 0.01 * *rc::gen::inRange(0, 21);
  const Sawtooth wave(3.0, 27.0, period_s, rise_share, Turnaround(share * period_s, mode_s));
  for (const double t_s : {0.0, period_s, 5.0 * period_s}) {
    RC_ASSERT(std::abs(wave.at(t_s).value_um - 3.0) < 1e-6);
    RC_ASSERT(std::abs(wave.at(t_s + wave.way_up_s()).value_um - 27.0) < 1e-6);
  }
  for (double t_s = 0.0; t_s < period_s; t_s += 0.0123 * period_s)
    RC_ASSERT(std::abs(wave.at(t_s).value_um - wave.at(t_s + 3.0 * period_s).value_um) < 1e-6);
}

constexpr Triangle triangle{.low_um = 3.0,
                            .high_um = 27.0,
                            .frequency_Hz = 10.0,
                            .cycles = 3.0,
                            .turnaround_percent = 10.0,
                            .mode_period_s = mode_s};

// 10 % of 100 ms: two turnarounds of 5 ms, 2.5 ms on each side of a corner.
TEST(TriangleWithTurnarounds, FollowsItsIdealLineExceptInItsTurnarounds) {
  const Shape shape = triangle;
  int apart = 0;
  for (int i = 0; i < 1000; ++i) {
    const double t_s = 0.1 + (i + 0.5) * 1e-4;
    if (std::abs(value_um(shape, t_s) - ideal_um(shape, t_s)) > 1e-9) ++apart;
  }
  EXPECT_NEAR(apart, 100, 2) << "of 1000 points of a period";
  EXPECT_EQ(value_um(shape, 0.1 + 2.6e-3), ideal_um(shape, 0.1 + 2.6e-3));
  EXPECT_GT(ideal_um(shape, 0.15), 27.4) << "its corners are beyond the ends";
}

TEST(TriangleWithTurnarounds, IsTheSameToTheBitWithoutThem) {
  Triangle sharp = triangle;
  sharp.turnaround_percent = 0.0;
  const Shape shape = sharp;
  EXPECT_EQ(value_um(shape, 0.0123), 3.0 + 24.0 * (1.0 - std::abs(2.0 * (0.0123 * 10.0) - 1.0)));
  EXPECT_EQ(ideal_um(shape, 0.0123), value_um(shape, 0.0123));
  EXPECT_EQ(motion_bounds(shape).peak_acceleration_um_per_s2, 0.0);
}

}  // namespace
}  // namespace hystcan::controller::turnaround_test
