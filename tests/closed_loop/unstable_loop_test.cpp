// Gains above the critical ones: the fault says that the loop oscillates. Faster growth may trip another limit first,
// `position jumped` or `position implausible`.
#include <gtest/gtest.h>

#include <string>

#include "config/schema/config.h"
#include "controller/analysis/margins.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"

namespace hystcan::unstable_loop_test {
namespace {

using controller::AxisState;
using controller::Cause;

constexpr const char* stages[]{"piezo.toml", "soft_stage.toml"};

/// The largest ki with which the linear loop is stable.
double critical_ki_per_s(const char* stage) {
  const rehearsal::Setup setup = support::shipped(stage);
  const controller::AxisConfig& axis = setup.controller.axes[0].axis;
  const controller::LinearLoop loop(
      controller::loop_config_of(axis.law, axis.delays, 1.0 / setup.controller.rate_Hz));
  return controller::largest_stable_gains(loop, axis.law.pi).ki_per_s.value();
}

Cause cause_with(const char* stage, double controller::Pi::Config::*gain, double value) {
  rehearsal::Setup setup = support::shipped(stage);  // a configuration with such gains is refused
  setup.controller.axes.resize(1);
  setup.controller.axes[0].axis.law.pi.*gain = value;
  setup.twin.axes.resize(1);
  rehearsal::Rehearsal loop(setup, support::ignore);
  loop.start();
  loop.run_for(std::chrono::seconds(15));
  return loop.controller().axis(0).fault().cause;
}

TEST(UnstableLoop, IsTheCauseAboveTheCriticalGain) {
  for (const char* stage : stages)
    for (const double factor : {1.15, 1.3})
      EXPECT_EQ(
          to_string(cause_with(stage, &controller::Pi::Config::ki_per_s, factor * critical_ki_per_s(stage))),
          "loop unstable")
          << stage << ", " << factor;
}

TEST(UnstableLoop, IsNoCauseBelowTheCriticalGain) {
  for (const char* stage : stages)
    for (const double factor : {0.2, 0.5, 0.8})
      EXPECT_EQ(
          to_string(cause_with(stage, &controller::Pi::Config::ki_per_s, factor * critical_ki_per_s(stage))),
          "none")
          << stage << ", " << factor;
}

TEST(UnstableLoop, IsTheCauseOfAProportionalGainThatIsTooHigh) {
  for (const double kp : {1.2})
    EXPECT_EQ(to_string(cause_with(stages[0], &controller::Pi::Config::kp, kp)), "loop unstable") << kp;
}

}  // namespace
}  // namespace hystcan::unstable_loop_test
