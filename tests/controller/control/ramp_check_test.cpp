// The check of the start-up's ramps and the course of the model, mostly on a stage without hysteresis: the
// last matching and the first contradicting position, the start of the judgement, and the allowances.
// tests/safety/ramp_check_test.cpp tests the check in an axis.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "controller/control/ramp_check.h"
#include "model/hysteresis_parameters.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::ramp_check_test {
namespace {

constexpr double cycle_s = 1e-3, half_volt = 0.5, um_per_volt = 0.3;

/// One cycle of a driven axis: the drive was commanded last.
void pass_cycle(Course& course, double drive, double dt_s, double of_s) {
  course.follow(drive);
  course.elapse(dt_s, of_s);
}

/// Only the ramp itself: no allowance for noise, the ramp's corners or the stage at rest.
RampCheck::Config strict() {
  return {.drive_range = 100.0, .mode_rad_per_s = 1e9, .decay_s = 1e9, .slope_shortfall = 0.3};
}

Delays delays(double lag_s) {
  return {.amplifier_bandwidth_Hz = 1.0 / (2.0 * std::numbers::pi * lag_s), .resonance_Hz = 1e9};
}

/// Returns the course of a stage without hysteresis.
Course straight(const Delays& delays, double gain = um_per_volt) {
  return {model::straight_line("V", "um", {0.0, 100.0}, {0.0, 100.0 * gain}), delays};
}

/// The check receives the value of the test as the mean over its two cycles.
class Ramp {
 public:
  explicit Ramp(const RampCheck::Config& config = strict(), double begin = 0.0, double lag_s = 1e-9,
                double gain = um_per_volt)
      : course_(straight(delays(lag_s), gain)), check_(config), gain_(gain), drive_(begin) {
    input_.dt_s = input_.cycle_s = cycle_s;
    course_.restart(begin);
    mark();
  }

  Ramp& rests(double seen_um) {
    show(seen_um);
    check_.rest(course_, drive_, input_);
    return *this;
  }
  /// Returns true if the position agrees, or has not contradicted for long enough.
  bool agrees(double volt, double seen_um) {
    show(seen_um);
    return step(volt);
  }
  bool agrees_without_sample(double volt) {
    input_.position_um.reset();
    return step(volt);
  }
  /// Moves the position with the model until the drive is reached.
  Ramp& follows_to(double end, double volt) {
    while (std::abs(end - drive_) > 0.25 * std::abs(volt))
      EXPECT_TRUE(agrees(volt, seen_um_ + gain_ * volt)) << drive_;
    return *this;
  }
  /// Returns the drive of a ramp to `end` at which the position, moving by a share of the model's motion,
  /// contradicts; -1: never.
  double contradicts_at(double volt, double end, double share) {
    while (std::abs(end - drive_) > 0.25 * std::abs(volt))
      if (!agrees(volt, seen_um_ + share * gain_ * volt)) return drive_;
    return -1.0;
  }

  /// Sets the motion added by the other axes.
  void add(double um) { coupled_um_ += um; }
  void mark() { mark_ = course_.mark(), marked_um_ = seen_um_; }
  /// Returns the rise of the model's delayed position in the next cycle, relative to the mark.
  double delayed_um(double volt) const {
    Course next = course_;
    pass_cycle(next, drive_ + volt, cycle_s, cycle_s);
    return next.mark()[2] - mark_[2];
  }
  double marked_um() const { return marked_um_; }

 private:
  void show(double seen_um) {
    input_.coupled_um = coupled_um_;
    input_.position_um = coupled_um_ + (is_first_ ? seen_um : seen_um_ + 3.0 * (seen_um - seen_um_));
    seen_um_ = seen_um;
    is_first_ = false;
  }
  bool step(double volt) {
    drive_ += volt;
    pass_cycle(course_, drive_, cycle_s, cycle_s);
    return check_.step(course_, drive_, input_);
  }

  Course course_;
  RampCheck check_;
  AxisInput input_;
  double gain_, drive_, seen_um_ = 0.0, coupled_um_ = 0.0;
  bool is_first_ = true;
  Course::Mark mark_{};
  double marked_um_ = 0.0;
};

TEST(CourseTest, DoesNotMoveIfTheDriveRests) {
  Course course(support::piezo_model(), {.sensor_delay = std::chrono::milliseconds(5)});
  for (const double drive : {20.0, 50.0}) {
    course.restart(drive);
    const Course::Mark begin = course.mark();
    for (int i = 0; i < 10; ++i) pass_cycle(course, drive, cycle_s, cycle_s);
    EXPECT_EQ(course.moved_um(begin).lo, 0.0);
    EXPECT_EQ(course.moved_um(begin).hi, 0.0);
  }
}

TEST(CourseTest, HasNoMemoryAfterARestart) {
  Course course(support::piezo_model(), {}), fresh = course;
  fresh.restart(50.0);
  course.restart(50.0);
  for (const double drive : {100.0, 60.0}) pass_cycle(course, drive, cycle_s, cycle_s);
  course.restart(50.0);
  EXPECT_EQ(course.mark(), fresh.mark());
  EXPECT_GT(fresh.mark()[0] - fresh.mark()[1], 1.0) << "from above and from below";
}

// A first-order lag of half a cycle, in which the drive is held, and of two more cycles.
TEST(CourseTest, HasADelayedPositionThatLagsByTheDelaysAndTwoCycles) {
  Course course = straight(delays(1e-9));
  course.restart(0.0);
  pass_cycle(course, 10.0, cycle_s, cycle_s);
  EXPECT_NEAR(course.moved_um({}).lo, 3.0 / 3.5, 1e-5);
  EXPECT_NEAR(course.moved_um({}).hi, 3.0, 1e-9);
}

TEST(CourseTest, HasAPureDelayAndThenALag) {
  for (const int delay : {1, 3, 31, 100}) {
    Delays late = delays(1e-9);
    late.sensor_delay = std::chrono::milliseconds(delay);
    Course course = straight(late);
    course.restart(0.0);
    int cycles = 0;
    while (course.moved_um({}).lo == 0.0 && cycles < 1000)
      pass_cycle(course, 10.0, cycle_s, cycle_s), ++cycles;
    EXPECT_NEAR(cycles, delay + 1, delay > 31 ? delay / 31.0 : 0.0);
    EXPECT_NEAR(course.moved_um({}).lo, 3.0 / 3.5, 1e-5);
  }
}

// A drive of one cycle, at any time.
TEST(CourseTest, DelaysEachCycleByUpTo31OfThem) {
  Delays late = delays(1e-9);
  late.sensor_delay = std::chrono::milliseconds(31);
  for (int before = 0; before < 64; ++before) {
    Course course = straight(late);
    course.restart(0.0);
    double highest_um = 0.0;
    for (int cycle = 0; cycle < before + 40; ++cycle) {
      pass_cycle(course, cycle == before ? 10.0 : 0.0, cycle_s, cycle_s);
      highest_um = std::max(highest_um, course.mark()[2]);
    }
    EXPECT_NEAR(highest_um, 3.0 / 3.5, 1e-5) << before;
  }
}

TEST(CourseTest, CountsHalfACycleAsAWholeOne) {
  for (const double length : {0.499, 0.5}) {
    Course course = straight(delays(1e-9));
    course.restart(0.0);
    pass_cycle(course, 10.0, length * cycle_s, cycle_s);
    EXPECT_EQ(course.moved_um({}).lo > 0.0, length == 0.5);
  }
}

// ---- size

TEST(RampCheck, AllowsThirtyPercentOfGainError) {
  for (const double gain : {um_per_volt, 0.1 * um_per_volt}) {
    const auto contradicts_at = [gain](double share) {
      return Ramp(strict(), 0.0, 1e-9, gain).rests(0.0).contradicts_at(half_volt, 100.0, share);
    };
    EXPECT_EQ(contradicts_at(0.701), -1.0);
    EXPECT_EQ(contradicts_at(1.0 / 0.7 - 0.002), -1.0);
    EXPECT_GT(contradicts_at(0.698), 0.0);
    EXPECT_GT(contradicts_at(1.0 / 0.7 + 0.002), 0.0);
  }
}

TEST(RampCheck, JudgesTheSizeFourteenPercentAfterTheFirstEight) {
  EXPECT_EQ(Ramp().rests(0.0).contradicts_at(half_volt, 100.0, 0.5), 23.5) << "beyond 22 V for three cycles";
  EXPECT_EQ(Ramp(strict(), 100.0).rests(30.0).contradicts_at(-half_volt, 0.0, 0.5), 76.5);
}

TEST(RampCheck, JudgesTheSizeAgainInWindowsOfSixteenPercent) {
  EXPECT_EQ(Ramp().rests(0.0).follows_to(24.0, half_volt).contradicts_at(half_volt, 100.0, 0.0), 39.5);
  EXPECT_EQ(Ramp().rests(0.0).follows_to(40.0, half_volt).contradicts_at(half_volt, 100.0, 0.0), 55.5);
}

TEST(RampCheck, JudgesTheSizeOfAFastRampEverySixCycles) {
  EXPECT_EQ(Ramp().rests(0.0).contradicts_at(5.0, 100.0, 0.5), 70.0) << "6, 6 and 3 cycles";
}

TEST(RampCheck, JudgesTheSizeAgainAfterATurn) {
  EXPECT_EQ(Ramp().rests(0.0).follows_to(40.0, half_volt).contradicts_at(-half_volt, 0.0, 0.5), 16.0);
}

TEST(RampCheck, SubtractsThePositionThatTheOtherAxesAdd) {
  Ramp ramp;
  ramp.rests(0.0);
  for (int i = 1; i <= 200; ++i) {
    ramp.add(-0.5);
    ASSERT_TRUE(ramp.agrees(half_volt, i * half_volt * um_per_volt));
  }
}

// ---- direction

/// Returns the number of ramp cycles after which a position contradicts that moves backwards by this share of
/// the delayed model's motion, and by this many um; 0: it agrees for ten cycles.
int cycles_until_it_contradicts(Ramp& ramp, double volt, double share, double beyond_um = 0.0) {
  const double sign = std::copysign(1.0, volt);
  for (int cycle = 1; cycle <= 10; ++cycle) {
    const double back_um = share * sign * ramp.delayed_um(volt) + beyond_um;
    if (!ramp.agrees(volt, ramp.marked_um() - sign * back_um)) return cycle;
  }
  return 0;
}

TEST(RampCheck, AllowsAPositionToMoveBackwardsByAQuarterOfTheRamp) {
  for (const double begin : {0.0, 50.0})
    for (const double share : {0.249, 0.251}) {
      Ramp ramp(strict(), begin);
      ramp.rests(0.0);
      const double volt = begin == 0.0 ? half_volt : -half_volt;
      EXPECT_EQ(cycles_until_it_contradicts(ramp, volt, share), share < 0.25 ? 0 : 3)
          << begin << ' ' << share;
    }
}

// After the turn, the delayed model rises for 12 more cycles while the drive falls.
TEST(RampCheck, AllowsThirtyPercentMoreRiseAfterATurn) {
  for (const double share : {1.42, 1.44}) {
    Ramp ramp(strict(), 0.0, 0.02);
    ramp.rests(0.0).follows_to(60.0, half_volt);
    ramp.agrees(-half_volt, um_per_volt * 60.0);
    ramp.mark();
    int cycle = 0;
    while (cycle < 6 && ramp.agrees(-half_volt, ramp.marked_um() + share * ramp.delayed_um(-half_volt)))
      ++cycle;
    EXPECT_EQ(cycle, share < 1.43 ? 6 : 2) << share;
  }
}

// 30 ms as configured, at 2 V per cycle: the position rises for 20 more cycles while the drive falls.
TEST(RampCheck, AcceptsASlowSensorThatStillRisesAfterTheTurn) {
  constexpr double tau_s = 0.03;
  Course course(support::piezo_model(), {.sensor_bandwidth_Hz = 1.0 / (2.0 * std::numbers::pi * tau_s)});
  RampCheck check({.drive_range = 100.0,
                   .stroke_um = 30.0,
                   .ramp_um_per_s = 600.0,
                   .mode_rad_per_s = 3e4,
                   .slope_shortfall = 0.3});
  course.restart(0.0);
  AxisInput input;
  input.dt_s = input.cycle_s = 1e-3;
  input.position_um = course.position_um();
  check.rest(course, 0.0, input);
  double drive = 0.0;
  for (int cycle = 0; cycle < 80; ++cycle) {
    drive += cycle < 50 ? 2.0 : -2.0;
    pass_cycle(course, drive, input.dt_s, input.cycle_s);
    *input.position_um += (course.position_um() - *input.position_um) * input.dt_s / (input.dt_s + tau_s);
    ASSERT_TRUE(check.step(course, drive, input)) << drive << " V, cycle " << cycle;
  }
}

TEST(RampCheck, TripsAtTheThirdContradictionInARow) {
  Ramp ramp;
  ramp.rests(0.0);
  const auto rises = [&] { return ramp.agrees(half_volt, 0.0); };
  const auto falls = [&] { return ramp.agrees(half_volt, -5.0); };
  EXPECT_TRUE(falls() && falls() && rises() && falls() && falls() && rises());
  EXPECT_TRUE(falls() && falls());
  EXPECT_FALSE(falls());
}

TEST(RampCheck, CountsOnlySamples) {
  Ramp ramp;
  ramp.rests(0.0);
  EXPECT_TRUE(ramp.agrees(half_volt, -5.0) && ramp.agrees(half_volt, -5.0));
  EXPECT_TRUE(ramp.agrees_without_sample(half_volt));
  EXPECT_FALSE(ramp.agrees(half_volt, -5.0));
}

TEST(RampCheck, RestartsItsCountAfterATurnEvenWithoutASample) {
  for (const bool with_sample : {true, false}) {
    Ramp ramp;
    ramp.rests(0.0).follows_to(4.0, half_volt);
    EXPECT_TRUE(ramp.agrees(half_volt, -5.0) && ramp.agrees(half_volt, -5.0));
    EXPECT_TRUE(with_sample ? ramp.agrees(-half_volt, -5.0) : ramp.agrees_without_sample(-half_volt));
    EXPECT_TRUE(ramp.agrees(-half_volt, 5.0) && ramp.agrees(-half_volt, 5.0)) << "above where it turned";
    EXPECT_FALSE(ramp.agrees(-half_volt, 5.0));
  }
}

// ---- the start of the ramp

// The load discharges: the position falls by 5 um while the drive does not change.
TEST(RampCheck, BeginsWhenTheDriveFirstMoves) {
  Ramp ramp;
  ramp.rests(0.0);
  for (int i = 1; i <= 50; ++i) EXPECT_TRUE(ramp.agrees(0.0, -0.1 * i));
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(ramp.agrees(half_volt, -5.0));
}

TEST(RampCheck, DoesNotBeginAgainIfTheDriveWaits) {
  for (const double sign : {1.0, -1.0}) {
    Ramp ramp(strict(), 50.0);
    ramp.rests(0.0).follows_to(50.0 + sign * 4.0, sign * half_volt);
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(ramp.agrees(0.0, sign * 1.2));
    EXPECT_TRUE(ramp.agrees(0.0, sign * -0.4) && ramp.agrees(0.0, sign * -0.4));
    EXPECT_FALSE(ramp.agrees(0.0, sign * -0.4))
        << "more than a quarter of 1.2 um behind where the ramp began";
  }
}

// ---- allowances for the position

/// Returns true if a ramp allows the position to be lower by this amount, besides a quarter of the model's
/// motion.
void expect_error_um(const Ramp& rested, double error_um) {
  for (const double share : {0.999, 1.001}) {
    Ramp ramp = rested;
    ramp.mark();
    EXPECT_EQ(cycles_until_it_contradicts(ramp, half_volt, 0.25, share * error_um) == 0, share < 1.0)
        << share << " of " << error_um << " um";
  }
}

TEST(RampCheck, AllowsThreeThousandthsOfTheStroke) {
  RampCheck::Config config = strict();
  config.stroke_um = 100.0;
  expect_error_um(Ramp(config).rests(0.0), 0.3);
}

TEST(RampCheck, AllowsTheRingingAtTheCornersOfTheRamp) {
  RampCheck::Config config = strict();
  config.ramp_um_per_s = 150.0;
  config.mode_rad_per_s = 300.0;
  expect_error_um(Ramp(config).rests(0.0), 0.5);
}

TEST(RampCheck, AllowsTheRangeOfThePositionAtRest) {
  expect_error_um(Ramp().rests(20.0).rests(20.5).rests(20.2), 0.5);
}

// A speed of 100 um/s at 1000 rad/s oscillates by 0.1 um.
TEST(RampCheck, AllowsAsMuchAsTheFastestSpeedAtRestSwingsInTheMode) {
  RampCheck::Config config = strict();
  config.mode_rad_per_s = 1000.0;
  expect_error_um(Ramp(config).rests(20.0).rests(20.1), 0.2);
  expect_error_um(Ramp(config).rests(20.0).rests(19.9), 0.2);
}

/// The range of 1 um at rest, which decays from the third sample on, even during the ramp.
void expect_forgotten_in(const RampCheck::Config& config, double cycles) {
  Ramp ramp(config);
  ramp.rests(19.5).rests(20.5);
  for (int i = 0; i < 200; ++i) ramp.rests(20.0);
  const double left = cycles / (cycles + 1.0);
  for (const double share : {0.999, 1.001}) {
    Ramp judged = ramp;
    judged.mark();
    bool agrees = true;
    for (int i = 1; i <= 3; ++i)
      agrees = judged.agrees(half_volt,
                             20.0 - 0.25 * judged.delayed_um(half_volt) - share * std::pow(left, 200 + i));
    EXPECT_EQ(agrees, share < 1.0) << share;
  }
}

TEST(RampCheck, DropsTheRangeAtRestInTwoHundredCycles) {
  RampCheck::Config config = strict();
  config.decay_s = 0.0;
  expect_forgotten_in(config, 200.0);
}

TEST(RampCheck, DropsTheRangeAtRestAsSlowlyAsTheModeDecays) {
  RampCheck::Config config = strict();
  config.decay_s = 0.4;
  expect_forgotten_in(config, 400.0);
}

}  // namespace
}  // namespace hystcan::controller::ramp_check_test
