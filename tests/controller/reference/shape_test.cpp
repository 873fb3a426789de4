// The properties of all shapes, and of each kind.
#include "controller/reference/shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace hystcan::controller::shape_test {
namespace {

MultiSine ten_tones() {
  MultiSine tones{.centre_um = 15.0, .amplitudes_um = {}, .frequencies_Hz = {}, .duration_s = 1.0};
  for (int k = 1; k <= 10; ++k) {
    tones.amplitudes_um.push_back(1.0);
    tones.frequencies_Hz.push_back(2.0 * k);
  }
  return tones;
}

Table bumps() {
  return {.file = "bumps.csv",
          .curve = MonotoneCubic({3.0, 3.1, 3.15, 3.4, 3.5}, {10.0, 20.0, 21.0, 5.0, 5.0})};
}

struct ShapeCase {
  Shape shape;
  std::string variant{};

  std::string name() const { return to_string(shape) + variant; }
  friend void PrintTo(const ShapeCase& test, std::ostream* out) { *out << test.name(); }
};

Shape scan(ScanRole role, SlowMotion slow, bool both_directions) {
  return prepared(Raster{.role = role,
                         .low_um = 5.0,
                         .high_um = 20.0,
                         .line_rate_Hz = 20.0,
                         .lines = 6,
                         .return_lines = 2,
                         .frames = 2,
                         .both_directions = both_directions,
                         .flyback_percent = 30.0,
                         .slow = slow,
                         .turnaround_percent = 20.0,
                         .mode_period_s = 2e-3});
}

const std::vector<ShapeCase>& shapes() {
  static const std::vector<ShapeCase> all{
      {Hold{.level_um = 4.0, .duration_s = 0.5}},
      {Step{.from_um = 3.0, .to_um = 7.0, .dwell_s = 0.1, .steps = 3}},
      {Ramp{.from_um = 3.0, .to_um = 7.0, .duration_s = 0.5}},
      {Triangle{.low_um = 3.0, .high_um = 27.0, .frequency_Hz = 10.0, .cycles = 2.0}},
      {Sine{.low_um = 5.0, .high_um = 25.0, .frequency_Hz = 5.0, .cycles = 2.5}},
      {Chirp{.low_um = 5.0, .high_um = 25.0, .from_Hz = 2.0, .to_Hz = 40.0, .duration_s = 0.5}},
      {prepared(ten_tones())},
      {Staircase{.levels_um = {10.0, 20.0, 5.0}, .rise_s = 0.1, .dwell_s = 0.2}},
      {Triangle{.low_um = 3.0,
                .high_um = 27.0,
                .frequency_Hz = 10.0,
                .cycles = 2.0,
                .turnaround_percent = 10.0,
                .mode_period_s = 2e-3},
       "WithTurnarounds"},
      {scan(ScanRole::fast, SlowMotion::step, true), "FastBothWays"},
      {scan(ScanRole::fast, SlowMotion::step, false), "FastOneWay"},
      {scan(ScanRole::slow, SlowMotion::step, true), "SlowInSteps"},
      {scan(ScanRole::slow, SlowMotion::step, false), "SlowInStepsDuringTheFlyback"},
      {scan(ScanRole::slow, SlowMotion::ramp, true), "SlowOnARamp"},
      {bumps()}};
  return all;
}

class EveryShape : public testing::TestWithParam<ShapeCase> {};

// Central differences over 2 us of curves whose third derivative is below 1e9 um/s^3: 1e-3 um/s.
TEST_P(EveryShape, ReportsItsVelocityAndAcceleration) {
  const Shape& shape = GetParam().shape;
  constexpr double h_s = 1e-6;
  const double length_s = duration_s(shape);
  const double fastest = motion_bounds(shape).peak_slew_um_per_s;
  for (int i = 1; i < 1000; ++i) {
    const double t_s = length_s * (i - 0.37) / 1000.0;  // avoids corners and jumps
    const Motion before = motion(shape, t_s - h_s);
    const Motion now = motion(shape, t_s);
    const Motion after = motion(shape, t_s + h_s);
    EXPECT_EQ(now.value_um, value_um(shape, t_s));
    EXPECT_NEAR((after.value_um - before.value_um) / (2.0 * h_s), now.velocity_um_per_s,
                1e-5 * fastest + 1e-6)
        << "at " << t_s;
    const double acceleration = (after.velocity_um_per_s - before.velocity_um_per_s) / (2.0 * h_s);
    EXPECT_NEAR(acceleration, now.acceleration_um_per_s2, 1e-4 * std::abs(acceleration) + 10.0)
        << "at " << t_s;
  }
}

TEST_P(EveryShape, StaysWithinTightBounds) {
  const Shape& shape = GetParam().shape;
  const MotionBounds stated = motion_bounds(shape);
  MotionBounds seen{.lowest_um = 1e9, .highest_um = -1e9};
  constexpr int points = 20'000;
  for (int i = 0; i < points; ++i) {
    const Motion at = motion(shape, duration_s(shape) * i / points);
    seen.lowest_um = std::min(seen.lowest_um, at.value_um);
    seen.highest_um = std::max(seen.highest_um, at.value_um);
    seen.peak_slew_um_per_s = std::max(seen.peak_slew_um_per_s, std::abs(at.velocity_um_per_s));
    seen.peak_acceleration_um_per_s2 =
        std::max(seen.peak_acceleration_um_per_s2, std::abs(at.acceleration_um_per_s2));
  }
  const double amplitudes_um = 0.002 * 10.0;  // error of a sampled multi-sine of ten tones
  EXPECT_NEAR(seen.lowest_um, stated.lowest_um, amplitudes_um);
  EXPECT_NEAR(seen.highest_um, stated.highest_um, amplitudes_um);
  EXPECT_LE(seen.peak_slew_um_per_s, 1.002 * stated.peak_slew_um_per_s + 1e-9);
  EXPECT_GE(seen.peak_slew_um_per_s, 0.9 * stated.peak_slew_um_per_s);
  EXPECT_LE(seen.peak_acceleration_um_per_s2, 1.002 * stated.peak_acceleration_um_per_s2 + 1e-9);
  EXPECT_GE(seen.peak_acceleration_um_per_s2, 0.8 * stated.peak_acceleration_um_per_s2);
}

TEST_P(EveryShape, RestsExactlyWhileItsValueIsConstant) {
  const Shape& shape = GetParam().shape;
  constexpr double h_s = 1e-4;
  for (int i = 0; i < 1000; ++i) {
    const double t_s = (duration_s(shape) - h_s) * (i + 0.37) / 1000.0;
    if (!rests(shape, t_s)) {
      EXPECT_NE(value_um(shape, t_s + h_s), value_um(shape, t_s)) << "at " << t_s;
    } else if (rests(shape, t_s + h_s)) {
      EXPECT_EQ(motion(shape, t_s).velocity_um_per_s, 0.0) << "at " << t_s;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shape, EveryShape, testing::ValuesIn(shapes().begin(), shapes().end() - 1),
                         [](const auto& test) {
                           std::string name = test.param.name();
                           std::erase(name, '-');
                           return name;
                         });

TEST(Step, JumpsAndDwells) {
  const Shape step = Step{.from_um = 10.0, .to_um = 12.0, .dwell_s = 0.25, .steps = 1};
  EXPECT_EQ(duration_s(step), 0.5);
  EXPECT_EQ(value_um(step, 0.2499), 10.0);
  EXPECT_EQ(value_um(step, 0.25), 12.0);
  EXPECT_EQ(value_um(step, 9.0), 12.0) << "held at its end";
  const Shape there_and_back = Step{.from_um = 10.0, .to_um = 12.0, .dwell_s = 0.25, .steps = 2};
  EXPECT_EQ(duration_s(there_and_back), 0.75);
  EXPECT_EQ(value_um(there_and_back, 0.75), 10.0);
}

// The phase is the integral of the frequency: from 10 to 30 Hz in 1 s it is 10 t + 10 t^2 cycles. Full
// amplitude from 0.1 s on; sin = 1 at a quarter of a cycle, t = 0.0244.
TEST(Chirp, IsExactInPhase) {
  const Shape chirp = Chirp{
      .low_um = 10.0, .high_um = 20.0, .from_Hz = 10.0, .to_Hz = 30.0, .duration_s = 1.0, .fade_s = 0.1};
  EXPECT_DOUBLE_EQ(duration_s(chirp), 1.2);
  for (const double cycles : {0.0, 1.0, 7.0, 15.0, 19.0}) {
    const double tau_s = (-10.0 + std::sqrt(100.0 + 40.0 * cycles)) / 20.0;
    EXPECT_NEAR(value_um(chirp, 0.1 + tau_s), 15.0, 1e-9) << cycles;
    const double quarter_s = (-10.0 + std::sqrt(100.0 + 40.0 * (cycles + 0.25))) / 20.0;
    EXPECT_NEAR(value_um(chirp, 0.1 + quarter_s), 20.0, 1e-9) << cycles;
  }
  EXPECT_NEAR(value_um(chirp, 1.1), 15.0, 1e-9) << "after 20 cycles";
}

TEST(Chirp, BeginsAndEndsAtItsCentreAtRest) {
  const Shape chirp = Chirp{.low_um = 5.0, .high_um = 25.0, .from_Hz = 2.0, .to_Hz = 41.0, .duration_s = 0.5};
  for (const double t_s : {0.0, duration_s(chirp)}) {
    EXPECT_NEAR(motion(chirp, t_s).value_um, 15.0, 1e-12);
    EXPECT_NEAR(motion(chirp, t_s).velocity_um_per_s, 0.0, 1e-9);
    EXPECT_NEAR(motion(chirp, t_s).acceleration_um_per_s2, 0.0, 1e-6);
  }
}

TEST(MultiSine, IsTheSumOfItsSines) {
  const Shape two = prepared(MultiSine{.centre_um = 15.0,
                                       .amplitudes_um = {1.0, 0.5},
                                       .frequencies_Hz = {10.0, 30.0},
                                       .phases_deg = {0.0, 90.0},
                                       .duration_s = 1.0,
                                       .fade_s = 0.1});
  EXPECT_NEAR(value_um(two, 0.1), 16.0, 1e-12);
  EXPECT_NEAR(value_um(two, 0.1 + 0.025), 15.0 + 0.5, 1e-12) << "cos(pi/2) + cos(3 pi/2 + pi/2) / 2";
  EXPECT_NEAR(value_um(two, 0.1 + 0.05), 14.0, 1e-12);
  EXPECT_NEAR(value_um(two, 0.0), 15.0, 1e-12);
}

// Ten sines of equal amplitude in phase reach 10, a crest factor of 4.47; Schroeder's phases bring it below
// 1.85 (his paper: about 1.7 for many).
TEST(MultiSine, HasALowPeakByDefault) {
  const auto crest = [](const MultiSine& tones) {
    const Shape shape = prepared(tones);
    return (motion_bounds(shape).highest_um - 15.0) / std::sqrt(10.0 / 2.0);
  };
  MultiSine in_phase = ten_tones();
  in_phase.phases_deg.assign(10, 0.0);
  EXPECT_NEAR(crest(in_phase), 4.47, 0.01);
  EXPECT_LT(crest(ten_tones()), 1.85);
}

// phi_k = -pi k (k - 1) / N for N equal amplitudes, of k = 1..N.
TEST(MultiSine, HasSchroedersPhases) {
  const auto tones = std::get<MultiSine>(prepared(ten_tones()));
  for (int k = 1; k <= 10; ++k) {
    const double difference_deg = tones.phases_deg[static_cast<std::size_t>(k - 1)] + 18.0 * k * (k - 1);
    EXPECT_NEAR(std::cos(difference_deg * std::numbers::pi / 180.0), 1.0, 1e-12) << k;
  }
}

TEST(MultiSine, RefusesNumbersThatContradictEachOther) {
  MultiSine tones = ten_tones();
  tones.frequencies_Hz.pop_back();
  EXPECT_THROW(prepared(tones), std::invalid_argument);
  tones = ten_tones();
  tones.phases_deg = {0.0};
  EXPECT_THROW(prepared(tones), std::invalid_argument);
}

TEST(MonotoneCubic, InterpolatesItsPointsWithoutOvershoot) {
  const MonotoneCubic curve = bumps().curve;
  EXPECT_NEAR(curve.length(), 0.5, 1e-12) << "counted from the first time on";
  EXPECT_EQ(curve.at(-1.0).value_um, 10.0);
  EXPECT_EQ(curve.at(0.0).value_um, 10.0);
  EXPECT_NEAR(curve.at(0.1).value_um, 20.0, 1e-9);
  EXPECT_NEAR(curve.at(0.15).value_um, 21.0, 1e-9);
  EXPECT_EQ(curve.at(7.0).value_um, 5.0);
  double before = 10.0;
  for (int i = 0; i <= 1000; ++i) {
    const double x = i * 0.0005;
    const double now = curve.at(x).value_um;
    if (x <= 0.15)
      EXPECT_GE(now, before - 1e-12) << x;
    else
      EXPECT_LE(now, before + 1e-12) << x;
    before = now;
  }
}

TEST(MonotoneCubic, BeginsAndEndsAtRestAndHasNoCorners) {
  const MonotoneCubic curve = bumps().curve;
  EXPECT_EQ(curve.at(0.0).velocity_um_per_s, 0.0);
  EXPECT_NEAR(curve.at(0.5 - 1e-12).velocity_um_per_s, 0.0, 1e-6);
  for (const double x : {0.1, 0.15, 0.4})
    EXPECT_NEAR(curve.at(x - 1e-9).velocity_um_per_s, curve.at(x + 1e-9).velocity_um_per_s, 1e-3) << x;
}

TEST(MonotoneCubic, IsStraightBetweenPointsOnALineExceptAtItsEnds) {
  const MonotoneCubic curve({0.0, 1.0, 2.5, 3.0, 4.0}, {0.0, 2.0, 5.0, 6.0, 8.0});
  for (const double x : {1.0, 1.7, 2.5, 2.9}) EXPECT_NEAR(curve.at(x).value_um, 2.0 * x, 1e-12);
  EXPECT_NEAR(curve.at(1.7).velocity_um_per_s, 2.0, 1e-12);
}

TEST(MonotoneCubic, RefusesPointsOutOfOrder) {
  EXPECT_THROW(MonotoneCubic({0.0}, {1.0}), std::invalid_argument);
  EXPECT_THROW(MonotoneCubic({0.0, 0.0}, {1.0, 2.0}), std::invalid_argument);
  EXPECT_THROW(MonotoneCubic({0.0, 1.0}, {1.0}), std::invalid_argument);
  EXPECT_THROW(MonotoneCubic({0.0, 1.0}, {1.0, std::nan("")}), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::controller::shape_test
