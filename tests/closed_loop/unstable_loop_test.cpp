// Gains above the critical ones, by ki up to twice: the fault says that the loop oscillates. Faster growth may trip
// `position jumped` first: kp 0.7 does, ki at three times the critical value does.
//
// Critical ki of the shipped stages, found by bisection: 1040 1/s for piezo.toml, 220 1/s for soft_stage.toml.
#include <gtest/gtest.h>

#include <string>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"

namespace hystcan::unstable_loop_test {
namespace {

using controller::AxisState;
using controller::Cause;

struct Stage {
  const char* file;
  double critical_ki_per_s;
};
constexpr Stage stages[]{{"piezo.toml", 1040.0}, {"soft_stage.toml", 220.0}};

Cause cause_with(const Stage& stage, const std::string& key, double value) {
  rehearsal::Setup setup = support::shipped(stage.file, {{"axis[0].control." + key, std::to_string(value)}});
  setup.controller.axes.resize(1);
  setup.twin.axes.resize(1);
  rehearsal::Rehearsal loop(setup, support::ignore);
  loop.start();
  loop.run_for(std::chrono::seconds(15));
  return loop.controller().axis(0).fault().cause;
}

TEST(UnstableLoop, IsTheCauseAboveTheCriticalGain) {
  for (const Stage& stage : stages)
    for (const double factor : {1.05, 1.1, 1.2, 1.5, 2.0})
      EXPECT_EQ(to_string(cause_with(stage, "ki_per_s", factor * stage.critical_ki_per_s)), "loop unstable")
          << stage.file << ", " << factor;
}

TEST(UnstableLoop, IsNoCauseBelowTheCriticalGain) {
  for (const Stage& stage : stages)
    for (const double factor : {0.2, 0.5, 0.8, 0.9})
      EXPECT_EQ(to_string(cause_with(stage, "ki_per_s", factor * stage.critical_ki_per_s)), "none")
          << stage.file << ", " << factor;
}

TEST(UnstableLoop, IsTheCauseOfAProportionalGainThatIsTooHigh) {
  for (const double kp : {1.2}) EXPECT_EQ(to_string(cause_with(stages[0], "kp", kp)), "loop unstable") << kp;
}

}  // namespace
}  // namespace hystcan::unstable_loop_test
