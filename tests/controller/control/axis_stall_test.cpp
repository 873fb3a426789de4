// The reaction of an axis to missed SYNCs: every motion of its own has waited for them.
#include <gtest/gtest.h>

#include "tests/controller/control/ideal_stage.h"
#include "tests/support/piezo.h"
#include "tests/support/shows.h"

namespace hystcan::controller::axis_stall_test {
namespace {

constexpr double rounding = 1e-9;

/// One step after a stall: five cycles after the last step, with four cycles in which the references waited.
constexpr double waited_s = 4 * cycle_s;
void after_a_stall(AxisInput& in) {
  in.time_s += waited_s;
  in.dt_s += waited_s;
  in.waited_s = waited_s;
}
void some_time_after_a_stall(AxisInput& in) {
  in.time_s += waited_s;
  in.waited_s = waited_s;
}

/// A ramp from 10 to 20 um at 100 um/s.
AxisConfig with_ramp() {
  AxisConfig config = support::piezo_axis();
  config.setpoint = {
      {.shape = Ramp{.from_um = 10.0, .to_um = 20.0, .duration_s = 0.1}, .transition_s = 0.05}};
  return config;
}

TEST(AxisAfterAStall, AdvancesTheReferenceByOneCycle) {
  shows("S-046");
  IdealStage stage(with_ramp());
  ASSERT_TRUE(stage.tracks());
  while (stage.axis.report().reference_um < 15.0) stage.cycle();
  const double before_um = stage.axis.report().reference_um;
  stage.cycle(after_a_stall);
  EXPECT_NEAR(stage.axis.report().reference_um - before_um, 100.0 * cycle_s, rounding);
  stage.cycle(some_time_after_a_stall);
  EXPECT_NEAR(stage.axis.report().reference_um - before_um, 2 * 100.0 * cycle_s, rounding);
}

TEST(AxisAfterAStall, RampsNoFurtherThanInOneCycle) {
  IdealStage stage;
  stage.axis.start(false);
  while (stage.command.drive < 50.0) stage.cycle();
  const double before = stage.command.drive;
  EXPECT_NEAR(stage.cycle(after_a_stall).drive - before, 1000.0 * cycle_s, rounding);
  EXPECT_NEAR(stage.cycle(some_time_after_a_stall).drive - before, 2 * 1000.0 * cycle_s, rounding);
}

TEST(AxisAfterAStall, IsSlewedNoFurtherThanInOneCycle) {
  IdealStage stage(with_ramp());
  ASSERT_TRUE(stage.tracks());
  while (stage.axis.report().reference_um < 15.0) stage.cycle();
  const double before = stage.command.drive;
  AxisConfig slow = with_ramp();
  slow.gate.slew_per_s = 100.0;
  AxisTuning tuning(slow, false);
  ASSERT_EQ(stage.axis.retune(tuning), std::nullopt);
  EXPECT_NEAR(stage.cycle(after_a_stall).drive - before, 100.0 * cycle_s, rounding);
  EXPECT_EQ(stage.axis.report().limits & limit::slew, limit::slew);
}

TEST(AxisAfterAStall, StartsALiveSetpointFromThePresentReference) {
  IdealStage stage(with_ramp());
  ASSERT_TRUE(stage.tracks());
  while (stage.axis.report().reference_um < 15.0) stage.cycle();
  stage.cycle(after_a_stall);
  const double before_um = stage.axis.report().reference_um;
  ASSERT_EQ(stage.axis.go_to(25.0), std::nullopt);
  stage.cycle(some_time_after_a_stall);
  EXPECT_NEAR(stage.axis.report().reference_um - before_um, 100.0 * cycle_s, rounding);
}

/// An axis that learns a hold in periods of 20 cycles.
std::uint32_t periods_learnt(bool stalls_in_each_period) {
  AxisConfig config = support::piezo_axis();
  config.learning.emplace(Learning::Config{.correction_max_um = 1.0});
  config.learning->plans = {{.phases = 20, .cycle_s = cycle_s, .taps = {1.0}, .duration_s = 1.0}};
  IdealStage stage(config);
  EXPECT_TRUE(stage.tracks());
  double waited_so_far_s = 0.0;
  for (int cycle = 0; cycle < 500; ++cycle)
    stage.cycle([&](AxisInput& in) {
      if (stalls_in_each_period && cycle % 20 == 0) {
        waited_so_far_s += waited_s;
        in.dt_s += waited_s;
      }
      in.time_s += waited_so_far_s;
      in.waited_s = waited_so_far_s;
    });
  return stage.axis.report().learning.periods;
}

TEST(LearningAfterAStall, BeginsANewPeriod) {
  EXPECT_GT(periods_learnt(false), 10u);
  EXPECT_EQ(periods_learnt(true), 0u);
}

}  // namespace
}  // namespace hystcan::controller::axis_stall_test
