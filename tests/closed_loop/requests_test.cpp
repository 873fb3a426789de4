// The result of a request: carried out, or refused with the reason.
#include "controller/requests.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>

#include "controller/analysis/learning_design.h"
#include "tests/support/rehearsed.h"
#include "tests/support/shows.h"

namespace hystcan::requests_test {
namespace {

using controller::AxisState;
using controller::Cause;
using controller::Refusal;
using std::chrono::milliseconds;
using Kind = controller::Request::Kind;

class RequestToAnAxis : public testing::Test {
 protected:
  controller::AxisConfig& config() { return setup_.controller.axes[0].axis; }
  void begin() {
    rehearsal_ = std::make_unique<rehearsal::Rehearsal>(setup_, support::ignore);
    rehearsal_->controller().listen_to(requests_);
    rehearsal_->start();
    run(1500);
    ASSERT_EQ(axis().state(), AxisState::tracking);
  }
  void run(int ms) { rehearsal_->run_for(milliseconds(ms)); }
  const controller::Axis& axis() const { return rehearsal_->controller().axis(0); }
  std::optional<Refusal> ask(Kind kind, std::size_t axis = 0) {
    auto request = std::make_unique<controller::Request>();
    request->kind = kind;
    request->axis = axis;
    EXPECT_TRUE(requests_.ask(std::move(request)));
    run(2);
    const auto answer = requests_.take_answer();
    EXPECT_TRUE(answer);
    return answer ? answer->refusal : std::nullopt;
  }
  void lose_samples(int ms) {
    twin::FaultSpec silent = twin::fault_spec(twin::Fault::no_reply, "x");
    silent.node = twin::Node::sensor;
    rehearsal_->twin().faults().inject(silent);
    run(ms);
    rehearsal_->twin().faults().remove(twin::Fault::no_reply);
    run(2);
  }

  rehearsal::Setup setup_ = support::shipped("piezo.toml");
  controller::RequestLink requests_;
  std::unique_ptr<rehearsal::Rehearsal> rehearsal_;
};

TEST_F(RequestToAnAxis, IsRefusedIfTheAxisDoesNotExist) {
  begin();
  EXPECT_EQ(ask(Kind::enable, 2), Refusal::no_such_axis);
  EXPECT_EQ(ask(Kind::enable, 1), Refusal::enabled_already);
}

TEST_F(RequestToAnAxis, ToEnableNeedsAnOfflineAxis) {
  begin();
  EXPECT_EQ(ask(Kind::enable), Refusal::enabled_already);
  EXPECT_EQ(ask(Kind::disable), std::nullopt);
  run(1000);
  ASSERT_EQ(axis().state(), AxisState::offline);
  EXPECT_EQ(ask(Kind::enable), std::nullopt);
  EXPECT_NE(axis().state(), AxisState::offline);
  run(1500);
  lose_samples(20);
  ASSERT_EQ(axis().state(), AxisState::faulted);
  EXPECT_EQ(ask(Kind::enable), Refusal::faulted);
}

TEST_F(RequestToAnAxis, ToDisableNeedsAnEnabledAxis) {
  begin();
  EXPECT_EQ(ask(Kind::disable), std::nullopt);
  run(1000);
  ASSERT_EQ(axis().state(), AxisState::offline);
  EXPECT_EQ(ask(Kind::disable), Refusal::not_enabled);
  ASSERT_EQ(ask(Kind::enable), std::nullopt);
  run(1500);
  lose_samples(20);
  ASSERT_EQ(axis().state(), AxisState::faulted);
  EXPECT_EQ(ask(Kind::disable), Refusal::not_enabled);
}

TEST_F(RequestToAnAxis, ToClearAFaultIsRefusedWhileTheDriveRampsDown) {
  config().fault_ramp_per_s = 20.0;
  begin();
  lose_samples(20);
  ASSERT_EQ(axis().fault().cause, Cause::sample_missing);
  ASSERT_TRUE(axis().is_in_use()) << "the drive ramps";
  EXPECT_EQ(ask(Kind::clear), Refusal::still_ramping);
  run(6000);
  EXPECT_EQ(ask(Kind::clear), std::nullopt);
  EXPECT_EQ(ask(Kind::clear), Refusal::no_fault_to_clear);
}

TEST_F(RequestToAnAxis, ToEnableDoesNotClearALatchedAmplifierFault) {
  shows("S-058");
  begin();
  ASSERT_EQ(ask(Kind::disable), std::nullopt);
  run(1000);
  node::AmplifierChannel& amplifier = rehearsal_->twin().axes()[0]->amplifier;
  amplifier.begin_internal_fault();
  amplifier.end_internal_fault();
  ASSERT_EQ(ask(Kind::enable), std::nullopt);
  run(2000);
  EXPECT_EQ(amplifier.state(), can::AmpState::fault);
  EXPECT_NE(axis().state(), AxisState::tracking);
}

TEST_F(RequestToAnAxis, ToRevertDiscardsTheLearntCorrection) {
  config().learning = controller::Learning::Config{.correction_max_um = 1.0};
  controller::plan_learning(config(), setup_.controller.rate_Hz);
  begin();
  run(2000);
  ASSERT_GT(axis().closed_loop()->learning()->report().periods, 0U);
  EXPECT_EQ(ask(Kind::revert), std::nullopt);
  EXPECT_EQ(axis().closed_loop()->learning()->report().periods, 0U);
}

TEST_F(RequestToAnAxis, ToRevertIsExecutedWithoutLearning) {
  begin();
  EXPECT_EQ(ask(Kind::revert), std::nullopt);
}

TEST_F(RequestToAnAxis, ToRevertIsExecutedInOpenLoop) {
  config().excitation = controller::Excitation::Hysteresis{.low = 10.0, .high = 70.0};
  begin();
  EXPECT_EQ(ask(Kind::revert), std::nullopt);
}

}  // namespace
}  // namespace hystcan::requests_test
