// Learning on a stage that responds at once: the errors that it uses, its pauses, and its end.
#include "controller/control/learning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "tests/support/count_allocations.h"

namespace hystcan::controller::learning_test {
namespace {

constexpr std::size_t phases = 20;
constexpr double cycle_s = 1e-3;

/// A period of 20 cycles and a filter of one tap: the error of a phase corrects this phase.
Learning::Config simple() {
  Learning::Config config{.rate = 0.5, .forget_percent = 0.0, .correction_max_um = 1.0};
  config.plans = {{.phases = phases, .cycle_s = cycle_s, .taps = {1.0}, .duration_s = 1e3}};
  return config;
}

/// A stage at the corrected reference plus a disturbance that repeats.
struct Bench {
  explicit Bench(const Learning::Config& config) : learning(config) {}
  Learning learning;
  std::size_t cycle = 1000;  // away from the start of the segment
  double gain = 1.0;
  double correction_um = 0.0, error_um = 0.0, largest_step_um = 0.0;
  std::function<double(std::size_t)> disturbance = [](std::size_t phase) {
    return 0.1 * std::sin(2.0 * std::numbers::pi * static_cast<double>(phase) / phases);
  };

  Trajectory::Point point() const { return {.shape_time_s = static_cast<double>(cycle) * cycle_s}; }
  void step(bool has_sample = true, bool undisturbed = true) { step_at(point(), has_sample, undisturbed); }
  void step_at(const Trajectory::Point& now, bool has_sample = true, bool undisturbed = true) {
    const double before_um = correction_um;
    correction_um = learning.correct(now, now, cycle_s).now_um;
    largest_step_um = std::max(largest_step_um, std::abs(correction_um - before_um));
    error_um = disturbance(cycle % phases) - gain * correction_um;
    learning.learn(now, has_sample ? std::optional(error_um) : std::nullopt, undisturbed);
    ++cycle;
  }
  double rms_of_periods(int periods) {
    double sum = 0.0;
    for (int i = 0; i < periods * static_cast<int>(phases); ++i) {
      step();
      sum += error_um * error_um;
    }
    return std::sqrt(sum / (periods * static_cast<double>(phases)));
  }
};

TEST(Learning, RemovesARepeatedError) {
  Bench run(simple());
  EXPECT_NEAR(run.rms_of_periods(1), 0.0707, 1e-3);
  run.rms_of_periods(20);
  EXPECT_LT(run.rms_of_periods(1), 1e-6);
  EXPECT_EQ(run.learning.report().state, LearningState::learning);
  EXPECT_GT(run.learning.report().periods, 15u);
  EXPECT_LT(run.learning.report().rms_um, 1e-5);
}

// 40.5 cycles: 40 phases, each a little longer than a cycle.
TEST(Learning, RemovesARepeatedErrorOfAFractionalPeriod) {
  Learning::Config config = simple();
  constexpr double period_s = 40.5 * cycle_s;
  config.plans[0].period_s = period_s;
  Learning learning(config);
  double sum_of_squares = 0.0;
  constexpr int all = 81 * 40, counted = 81 * 10;
  for (int n = 0; n < all; ++n) {
    const Trajectory::Point now{.shape_time_s = (1000 + n) * cycle_s};
    const double disturbance_um = 0.1 * std::sin(2.0 * std::numbers::pi * now.shape_time_s / period_s);
    const double error_um = disturbance_um - learning.correct(now, now, cycle_s).now_um;
    learning.learn(now, error_um, true);
    if (n >= all - counted) sum_of_squares += error_um * error_um;
  }
  EXPECT_LT(std::sqrt(sum_of_squares / counted), 0.003);
}

TEST(Learning, RevertsTheCorrectionIfItDiverges) {
  Bench run(simple());
  run.gain = -1.0;  // every correction increases the error
  run.rms_of_periods(40);
  EXPECT_EQ(run.learning.report().state, LearningState::diverged);
  EXPECT_NEAR(run.correction_um, 0.0, 1e-9);
  EXPECT_NEAR(run.rms_of_periods(1), 0.0707, 1e-3) << "as without learning";
  EXPECT_LT(run.largest_step_um, 0.3) << "the correction fades out";
}

TEST(Learning, LeavesWithoutAJump) {
  const auto leaves = [](auto leave) {
    Bench run(simple());
    run.disturbance = [](std::size_t) { return 0.5; };
    run.rms_of_periods(30);
    EXPECT_NEAR(run.correction_um, 0.5, 1e-3);
    run.largest_step_um = 0.0;
    leave(run);
    EXPECT_LT(run.largest_step_um, 0.06);
    EXPECT_NEAR(run.correction_um, 0.0, 0.01);
  };
  leaves([](Bench& run) {
    for (int i = 0; i < 200; ++i) {
      Trajectory::Point point = run.point();
      point.live = true;
      run.step_at(point);
    }
  });
  leaves([](Bench& run) {
    run.learning.retire();
    for (int i = 0; i < 200; ++i) run.step();
  });
  leaves([](Bench& run) {
    run.disturbance = [](std::size_t) { return 0.0; };
    run.gain = 0.0;
    run.learning.reset();
    for (int i = 0; i < 200; ++i) run.step();
  });
}

TEST(Learning, FrozenCorrectsButDoesNotLearn) {
  Bench run(simple());
  run.rms_of_periods(10);
  Learning::Config frozen = simple();
  frozen.frozen = true;
  Learning next(frozen);
  next.continue_from(run.learning);
  const auto before = next.table();
  EXPECT_EQ(before, run.learning.table());
  run.learning = next;
  run.disturbance = [](std::size_t) { return 0.3; };
  run.rms_of_periods(5);
  EXPECT_EQ(run.learning.table(), before);
  EXPECT_EQ(run.learning.report().state, LearningState::frozen);
}

/// Returns a learning with segments that repeat after so many cycles.
Learning of_segments(const std::vector<std::size_t>& cycles) {
  Learning::Config config = simple();
  config.plans.clear();
  for (const std::size_t phases_of_one : cycles)
    config.plans.push_back({.phases = phases_of_one, .cycle_s = cycle_s, .taps = {1.0}, .duration_s = 1.0});
  return Learning(config);
}

TEST(Learning, RestoresOnlyATableOfItsOwnSize) {
  Bench run(simple());
  run.rms_of_periods(10);
  Learning other(simple());
  EXPECT_TRUE(other.restore(run.learning.table()));
  EXPECT_EQ(other.table(), run.learning.table());
  EXPECT_FALSE(other.restore({}));
  EXPECT_FALSE(other.restore({{1.0, 2.0}}));
  EXPECT_EQ(other.table(), run.learning.table());
}

TEST(Learning, RestoresNoCorrectionBeyondItsBound) {
  Learning learning = of_segments({2});
  EXPECT_TRUE(learning.restore({{5.0, -5.0}}));
  EXPECT_EQ(learning.table(), (std::vector<std::vector<double>>{{1.0, -1.0}}));
}

// The learnt correction removes the whole error, and there was no error without it.
TEST(Learning, KeepsACorrectionThatRemovesTheWholeError) {
  Learning learning = of_segments({2});
  EXPECT_TRUE(learning.restore({{0.1, 0.2}}));
  for (int cycle = 2; cycle < 100; ++cycle) learning.learn({.shape_time_s = cycle * cycle_s}, 0.0, true);
  EXPECT_EQ(learning.table(), (std::vector<std::vector<double>>{{0.1, 0.2}}));
  EXPECT_EQ(learning.report().periods, 48u);
}

TEST(Learning, RestoresAllSegmentsOrNone) {
  Learning learning = of_segments({2, 3});
  const std::vector<std::vector<double>> table{{0.1, 0.2}, {0.3, 0.4, 0.5}};
  EXPECT_TRUE(learning.restore(table));
  EXPECT_EQ(learning.table(), table);
  EXPECT_FALSE(learning.restore({{0.6, 0.6}, {0.6}}));
  EXPECT_EQ(learning.table(), table);
}

TEST(Learning, ContinuesInSegmentsOfEqualPeriod) {
  Learning before = of_segments({2, 3});
  EXPECT_TRUE(before.restore({{0.1, 0.2}, {0.3, 0.4, 0.5}}));
  Learning same = of_segments({2, 3});
  same.continue_from(before);
  EXPECT_EQ(same.table(), before.table());
  Learning more = of_segments({2, 4, 3});
  more.continue_from(before);
  EXPECT_EQ(more.table(), (std::vector<std::vector<double>>{{0.1, 0.2}, {0, 0, 0, 0}, {0, 0, 0}}));
  Learning fewer = of_segments({2});
  fewer.continue_from(before);
  EXPECT_EQ(fewer.table(), (std::vector<std::vector<double>>{{0.1, 0.2}}));
}

TEST(Learning, ContinuesItsReport) {
  Bench run(simple());
  run.rms_of_periods(3);
  Learning next(simple());
  next.continue_from(run.learning);
  EXPECT_EQ(next.report().periods, run.learning.report().periods);
  EXPECT_GT(next.report().periods, 0u);
}

TEST(Learning, CoversASegmentThatRepeatsUntilItsEnd) {
  const Learning learning = of_segments({2});
  EXPECT_TRUE(learning.covers({.shape_time_s = std::nextafter(1.0, 0.0)}));
  EXPECT_FALSE(learning.covers({.shape_time_s = 1.0}));
  EXPECT_FALSE(learning.covers({.in_transition = true}));
  EXPECT_FALSE(learning.covers({.segment = 1}));
}

TEST(Learning, IsLearningEvenWithoutSegments) {
  EXPECT_EQ(of_segments({}).report().state, LearningState::learning);
}

// The limit is four times the largest error.
TEST(Learning, IgnoresErrorsAboveFourTimesTheLargest) {
  for (const double error_um : {0.4, std::nextafter(0.4, 1.0)}) {
    Bench run(simple());
    run.disturbance = [](std::size_t) { return 0.1; };
    run.rms_of_periods(1);
    for (int i = 0; i < 2; ++i) run.step();
    const std::vector<std::vector<double>> before = run.learning.table();
    run.learning.learn(run.point(), error_um, true);
    EXPECT_EQ(run.learning.table() == before, error_um > 0.4);
  }
}

TEST(Learning, AllocatesNothingInACycle) {
  Bench run(simple());
  run.disturbance = nullptr;
  const Trajectory::Point point = run.point();
  const auto before = support::allocations_so_far();
  run.learning.correct(point, point, cycle_s);
  run.learning.learn(point, 0.1, true);
  run.learning.reset();
  EXPECT_EQ(support::allocations_so_far(), before);
}

TEST(Learning, RefusesAnInvalidFilter) {
  Learning::Config config = simple();
  config.plans[0].taps = {0.5, 0.5};
  EXPECT_THROW(Learning{config}, std::invalid_argument);
  config.plans[0].taps.assign(phases + 1, 0.1);
  EXPECT_THROW(Learning{config}, std::invalid_argument);
  config.plans[0] = {.phases = phases, .cycle_s = 0.0, .taps = {1.0}};
  EXPECT_THROW(Learning{config}, std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::controller::learning_test
