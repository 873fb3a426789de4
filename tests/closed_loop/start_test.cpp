// The time at which the axes of one controller begin to track: together, after a limited wait, and one by one
// after a fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"
#include "tests/support/shows.h"

namespace hystcan::start_test {
namespace {

using controller::ArmingBlock;
using controller::AxisState;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Kind = controller::Request::Kind;

/// The shipped two-axis stage. Its axis y can be left out.
class Start : public testing::Test {
 protected:
  static rehearsal::Setup setup(const std::vector<config::Setting>& settings = {}) {
    return support::shipped("piezo.toml", settings);
  }
  static rehearsal::Setup without_y(const std::vector<config::Setting>& settings = {}) {
    rehearsal::Setup setup = Start::setup(settings);
    setup.twin.axes.pop_back();
    return setup;
  }
  void begin(const rehearsal::Setup& setup) {
    loop_ = std::make_unique<rehearsal::Rehearsal>(setup, support::ignore);
    loop_->controller().listen_to(requests_);
    loop_->start();
  }
  const controller::Axis& axis(std::size_t i) { return std::as_const(loop_->controller()).axis(i); }
  bool reaches(std::size_t i, AxisState state, can::Duration limit) {
    for (can::Duration spent{}; spent < limit && axis(i).state() != state; spent += milliseconds(1))
      loop_->run_for(milliseconds(1));
    return axis(i).state() == state;
  }
  void ask(Kind kind, std::size_t i) {
    auto request = std::make_unique<controller::Request>();
    request->kind = kind;
    request->axis = i;
    ASSERT_TRUE(requests_.ask(std::move(request)));
    loop_->run_for(milliseconds(2));
    EXPECT_EQ(requests_.take_answer()->refusal, std::nullopt);
  }

  void fault_and_arm_again(std::size_t i) {
    node::AmplifierChannel& amplifier = loop_->twin().axes()[i]->amplifier;
    amplifier.begin_internal_fault();
    ASSERT_TRUE(reaches(i, AxisState::faulted, milliseconds(50)));
    amplifier.end_internal_fault();
    ask(Kind::clear, i);
    ask(Kind::enable, i);
    ASSERT_TRUE(reaches(i, AxisState::tracking, seconds(3)));
  }

  controller::RequestLink requests_;
  std::unique_ptr<rehearsal::Rehearsal> loop_;
};

TEST_F(Start, BeginsInTheSameCycleForAllAxes) {
  begin(setup());
  ASSERT_TRUE(reaches(0, AxisState::tracking, seconds(5)));
  EXPECT_EQ(axis(1).state(), AxisState::tracking);
}

TEST_F(Start, ContinuesAfterFiveSecondsWithoutAMissingAxis) {
  begin(without_y());
  ASSERT_TRUE(reaches(0, AxisState::ready, seconds(2)));
  loop_->run_for(milliseconds(4990));
  EXPECT_EQ(axis(0).state(), AxisState::ready);
  EXPECT_EQ(axis(0).report().arming_blocks, ArmingBlock::other_axes);
  EXPECT_EQ(axis(1).report().arming_blocks.members(),
            (std::vector<ArmingBlock>{ArmingBlock::sensor_heartbeat, ArmingBlock::amplifier_heartbeat}))
      << "the log and the status say so";
  EXPECT_TRUE(reaches(0, AxisState::tracking, milliseconds(20)));
}

TEST_F(Start, DoesNotWaitIfAxesMayBeginSeparately) {
  begin(without_y({{"controller.start_together", "false"}}));
  ASSERT_TRUE(reaches(0, AxisState::ready, seconds(2)));
  EXPECT_TRUE(reaches(0, AxisState::tracking, milliseconds(2)));
}

TEST_F(Start, DoesNotWaitForAFaultedAxis) {
  shows("S-004");
  begin(setup());
  ASSERT_TRUE(reaches(1, AxisState::initialising, seconds(2)));
  loop_->twin().axes()[1]->amplifier.begin_internal_fault();
  ASSERT_TRUE(reaches(1, AxisState::faulted, milliseconds(50)));
  ASSERT_TRUE(reaches(0, AxisState::ready, seconds(2)));
  EXPECT_TRUE(reaches(0, AxisState::tracking, milliseconds(2)));
}

// A former error: the axis rested for as long as the others had tracked when it joined, then jumped into the
// reference.
TEST_F(Start, RestartsTheReferenceOfAnAxisThatHadJoinedLater) {
  begin(setup());
  ASSERT_TRUE(reaches(1, AxisState::tracking, seconds(5)));
  loop_->run_for(milliseconds(300));
  ASSERT_NO_FATAL_FAILURE(fault_and_arm_again(1));
  const auto& axes = loop_->twin().axes();
  for (const auto& stage : axes) stage->amplifier.begin_internal_fault();
  ASSERT_TRUE(reaches(0, AxisState::faulted, milliseconds(50)) &&
              reaches(1, AxisState::faulted, milliseconds(50)));
  for (const auto& stage : axes) stage->amplifier.end_internal_fault();
  for (const Kind kind : {Kind::clear, Kind::enable})
    for (const std::size_t i : {0U, 1U}) ask(kind, i);
  ASSERT_TRUE(reaches(0, AxisState::tracking, seconds(3)));
  ASSERT_EQ(axis(1).state(), AxisState::tracking);
  const double start_um = axis(1).report().reference_um;
  loop_->run_for(milliseconds(200));  // transition_s
  EXPECT_NEAR(axis(1).report().reference_um, 5.0, 0.1) << "from " << start_um << " um to low_um";
}

TEST_F(Start, SynchronisesARearmedAxisWithTheOthers) {
  shows("S-004");
  begin(setup());
  rehearsal::Rehearsal undisturbed(setup(), support::ignore);
  undisturbed.start();
  ASSERT_TRUE(reaches(1, AxisState::tracking, seconds(5)));
  loop_->run_for(milliseconds(300));
  ASSERT_NO_FATAL_FAILURE(fault_and_arm_again(1));
  EXPECT_EQ(axis(0).state(), AxisState::tracking) << "the other axis has gone on";
  loop_->run_for(seconds(1));
  undisturbed.run_for(loop_->clock().now() - undisturbed.clock().now());
  const controller::Axis& other = std::as_const(undisturbed.controller()).axis(1);
  ASSERT_EQ(other.state(), AxisState::tracking);
  EXPECT_NEAR(axis(1).report().reference_um, other.report().reference_um, 1e-9);
  EXPECT_NEAR(axis(1).report().position_um, other.report().position_um, 0.1);
}

// Its reference restarted after a live goal, later than that of the other axis.
TEST_F(Start, KeepsTheReferenceStartOfARearmedAxis) {
  begin(setup());
  rehearsal::Rehearsal undisturbed(setup(), support::ignore);
  undisturbed.start();
  ASSERT_TRUE(reaches(1, AxisState::tracking, seconds(5)));
  undisturbed.run_for(loop_->clock().now() - undisturbed.clock().now());
  for (rehearsal::Rehearsal* loop : {loop_.get(), &undisturbed}) {
    EXPECT_EQ(loop->controller().axis(1).go_to(12.0), std::nullopt);
    loop->run_for(milliseconds(317));
    EXPECT_EQ(loop->controller().axis(1).resume(), std::nullopt);
    loop->run_for(milliseconds(500));
  }
  ASSERT_NO_FATAL_FAILURE(fault_and_arm_again(1));
  loop_->run_for(seconds(1));
  undisturbed.run_for(loop_->clock().now() - undisturbed.clock().now());
  const controller::Axis& other = std::as_const(undisturbed.controller()).axis(1);
  EXPECT_NEAR(axis(1).report().reference_um, other.report().reference_um, 1e-9);
}

TEST_F(Start, MovesARearmedAxisNoFasterThanATransition) {
  begin(setup());
  ASSERT_TRUE(reaches(1, AxisState::tracking, seconds(5)));
  ASSERT_NO_FATAL_FAILURE(fault_and_arm_again(1));
  double before_um = axis(1).report().reference_um, largest_um = 0.0;
  EXPECT_NEAR(before_um, axis(1).report().position_um, 1e-9) << "it begins where the stage is";
  for (int i = 0; i < 400; ++i) {
    loop_->run_for(milliseconds(1));
    const double now_um = axis(1).report().reference_um;
    largest_um = std::max(largest_um, std::abs(now_um - before_um));
    before_um = now_um;
  }
  // A 5 Hz sine of 20 um, and 25 um within 0.2 s.
  EXPECT_LT(largest_um, 0.314 + 1.875 * 25.0 / 200.0);
}

}  // namespace
}  // namespace hystcan::start_test
