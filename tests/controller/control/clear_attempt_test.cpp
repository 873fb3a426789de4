// The attempt to clear the amplifier's fault: its duration, and the starts that make it.
#include <gtest/gtest.h>

#include "controller/control/arming.h"
#include "tests/controller/control/ideal_stage.h"

namespace hystcan::controller::clear_attempt_test {
namespace {

constexpr NodeHealth faulty{.amplifier_operational = true, .amplifier_fault = true};

TEST(ClearAttempt, CommandsNothingBeforeItBegins) {
  EXPECT_FALSE(ClearAttempt().step(faulty, exact_cycle_s));
}

TEST(ClearAttempt, LastsForHalfASecond) {
  ClearAttempt attempt;
  attempt.begin();
  for (int i = 0; i < 512; ++i) ASSERT_TRUE(attempt.step(faulty, exact_cycle_s)) << i;
  EXPECT_FALSE(attempt.step(faulty, exact_cycle_s));
}

TEST(ClearAttempt, DoesNotCountTheTimeInWhichTheAmplifierIsNotOperational) {
  ClearAttempt attempt;
  attempt.begin();
  const NodeHealth stopped{.amplifier_fault = true};
  for (int i = 0; i < 2000; ++i) ASSERT_TRUE(attempt.step(stopped, exact_cycle_s));
  for (int i = 0; i < 512; ++i) ASSERT_TRUE(attempt.step(faulty, exact_cycle_s));
  EXPECT_FALSE(attempt.step(faulty, exact_cycle_s));
}

TEST(ClearAttempt, CommandsNothingIfTheAmplifierHasNoFault) {
  ClearAttempt attempt;
  attempt.begin();
  EXPECT_FALSE(attempt.step({.amplifier_operational = true}, exact_cycle_s));
}

void faulted(AxisInput& in) {
  in.health.amplifier_fault = true;
  in.health.amplifier_ready = false;
}

TEST(ClearAttempt, IsMadeOnlyByAStartThatRequestsIt) {
  IdealStage strict;
  strict.axis.start(false);
  EXPECT_FALSE(strict.cycle(faulted).clear_fault);
  EXPECT_EQ(strict.axis.state(), AxisState::faulted);
  EXPECT_EQ(strict.axis.fault().cause, Cause::amplifier_fault);

  IdealStage clearing;
  clearing.axis.start(true);
  const AxisCommand command = clearing.cycle(faulted);
  EXPECT_TRUE(command.clear_fault);
  EXPECT_FALSE(command.enable);
  EXPECT_EQ(clearing.axis.state(), AxisState::waiting);
  EXPECT_TRUE(clearing.reaches(AxisState::tracking));
  EXPECT_FALSE(clearing.command.clear_fault) << "the clearing is requested only once";
}

TEST(ClearAttempt, IsMadeAtTheStartAfterAClear) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  stage.cycle(faulted);
  ASSERT_EQ(stage.axis.fault().cause, Cause::amplifier_fault);
  ASSERT_EQ(stage.axis.clear(), std::nullopt);
  stage.axis.start(false);
  EXPECT_TRUE(stage.cycle(faulted).clear_fault);
  EXPECT_EQ(stage.axis.state(), AxisState::waiting);
}

TEST(ClearAttempt, EndsWithTheStartThatRequestedIt) {
  IdealStage stage;
  stage.axis.start(true);
  ASSERT_TRUE(stage.reaches(AxisState::tracking));
  stage.axis.stop();
  ASSERT_TRUE(stage.reaches(AxisState::offline));
  stage.axis.start(false);
  EXPECT_FALSE(stage.cycle(faulted).clear_fault);
  EXPECT_EQ(stage.axis.fault().cause, Cause::amplifier_fault);
}

TEST(ClearAttempt, EndsAtAStop) {
  IdealStage stage;
  stage.axis.start(true);
  stage.cycle(faulted);
  stage.axis.stop();
  stage.cycle(faulted);
  ASSERT_EQ(stage.axis.state(), AxisState::offline);
  stage.axis.start(false);
  EXPECT_FALSE(stage.cycle(faulted).clear_fault);
  EXPECT_EQ(stage.axis.state(), AxisState::faulted);
}

}  // namespace
}  // namespace hystcan::controller::clear_attempt_test
