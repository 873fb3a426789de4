// The frames that the controller sends besides SYNC and commands, cycle by cycle and without a bus: their
// order.
#include "controller/background_frames.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/outbox.h"
#include "tests/support/rehearsed.h"

namespace hystcan::background_frames_test {
namespace {

using can::NmtState;
using controller::AxisState;
using std::chrono::milliseconds;
using Sent = std::vector<std::string>;

std::string in_words(const can::Frame& frame) {
  switch (frame.id) {
    case 0x000:
      return fmt::format("{} {}", to_string(static_cast<can::NmtCommand>(frame.data[0])), frame.data[1]);
    case 0x281:
      return "status of x";
    case 0x283:
      return "status of y";
    case 0x381:
      return "marker of x";
    case 0x70A:
      return frame.data[0] == 0 ? "boot-up" : "heartbeat";
    default:
      return fmt::format("{:03X}", frame.id);
  }
}

/// The axes x, with the nodes 1 (amplifier) and 2 (sensor), and y, with 3 and 4. All nodes are offline at
/// first.
class Background : public testing::Test {
 protected:
  controller::WiredAxisConfig& config(std::size_t axis) { return setup_.controller.axes[axis]; }
  void add_axis(const controller::WiredAxisConfig& config) {
    axes_.push_back(std::make_unique<controller::WiredAxis>(config, axes_.size(), std::chrono::hours(1),
                                                            setup_.database, shared_));
  }
  void begin(unsigned slots = 0) {
    for (const auto& config : setup_.controller.axes) add_axis(config);
    frames_ = std::make_unique<controller::BackgroundFrames>(10, milliseconds(100), slots, axes_);
    frames_->start(bus_, can::Time{});
    EXPECT_EQ(sent(), Sent{"boot-up"});
  }
  Sent sent() {
    Sent words;
    for (const can::Frame& frame : bus_.frames) words.push_back(in_words(frame));
    bus_.frames.clear();
    return words;
  }
  /// Returns the frames that follow the commands of the cycle whose SYNC was sent at this time.
  Sent at(int ms) {
    const can::Time sync_sent{milliseconds(ms)};
    frames_->send_next(bus_, sync_sent, sync_sent, 1e-3 * ms);
    return sent();
  }
  /// Returns the frames that follow the SYNC with this counter.
  Sent in_slot(int sync_counter, int ms) {
    frames_->begin_cycle(bus_, static_cast<std::uint8_t>(sync_counter), can::Time{milliseconds(ms)});
    return sent();
  }
  void hear(controller::RemoteNode& node, NmtState state) {
    node.on_heartbeat(can::heartbeat_frame(node.node(), state), can::Time{});
  }
  /// Makes the axis wait for its nodes, and updates the log accordingly.
  void wait(std::size_t axis) {
    axes_[axis]->axis.start(false);
    axes_[axis]->axis.step({});
    axes_[axis]->status_sender.send(axes_[axis]->axis, bus_);
    bus_.frames.clear();
    EXPECT_EQ(axes_[axis]->axis.state(), AxisState::waiting);
  }
  static std::vector<can::SdoWrite> one_object() {
    return {{{.index = 0x2001, .subindex = 2}, {.value = 5}}};
  }
  /// Answers the set-up requests of a node until its set-up is complete.
  void answer_set_up(controller::RemoteNode& node) {
    const can::SdoObject object = one_object()[0].object;
    node.on_sdo(can::sdo_response(node.node(), {.service = can::SdoService::written, .object = object}));
    node.poll_setup({});
    node.on_sdo(can::sdo_response(
        node.node(), {.service = can::SdoService::value, .object = object, .content = {.value = 5}}));
    EXPECT_TRUE(node.is_set_up());
  }

  rehearsal::Setup setup_ = support::shipped("piezo.toml");
  controller::SharedFrames shared_;
  controller::WiredAxes axes_;
  support::Outbox bus_;
  std::unique_ptr<controller::BackgroundFrames> frames_;
};

TEST_F(Background, BeginsWithTheBootUpAndAHeartbeatAPeriodLater) {
  begin();
  EXPECT_EQ(at(0), Sent{});
  EXPECT_EQ(at(99), Sent{});
  EXPECT_EQ(at(100), (Sent{"status of x", "heartbeat"}));
}

TEST_F(Background, ReportsTheAxesInTurnWithEachHeartbeat) {
  begin();
  EXPECT_EQ(at(100), (Sent{"status of x", "heartbeat"}));
  EXPECT_EQ(at(101), Sent{"status of y"});
  EXPECT_EQ(at(102), Sent{});
  EXPECT_EQ(at(200), (Sent{"status of x", "heartbeat"}));
  EXPECT_EQ(at(201), Sent{"status of y"});
}

TEST_F(Background, ReportsThreeAxesInTheirOrder) {
  setup_.controller.axes.push_back(setup_.controller.axes[0]);
  begin();
  EXPECT_EQ(at(100), (Sent{"status of x", "heartbeat"}));
  EXPECT_EQ(at(101), Sent{"status of y"});
  EXPECT_EQ(at(102), Sent{"status of x"});
}

TEST_F(Background, ReportsANewStateOutOfTurn) {
  begin();
  axes_[1]->axis.start(false);
  axes_[1]->axis.step({});
  EXPECT_EQ(at(1), Sent{"status of y"});
}

TEST_F(Background, DoesNotSendMissedHeartbeatsLater) {
  begin();
  EXPECT_EQ(at(350), (Sent{"status of x", "heartbeat"}));
  EXPECT_EQ(at(449), Sent{"status of y"});
  EXPECT_EQ(at(450), (Sent{"heartbeat", "status of x"})) << "a status was sent in the cycle before";
}

TEST_F(Background, SendsTheNextHeartbeatAPeriodAfterALateOne) {
  begin();
  EXPECT_EQ(at(200), (Sent{"status of x", "heartbeat"}));
  EXPECT_EQ(at(201), Sent{"status of y"});
  EXPECT_EQ(at(299), Sent{});
  EXPECT_EQ(at(300), (Sent{"status of x", "heartbeat"}));
}

TEST_F(Background, SendsAMarkerBeforeAnyStatus) {
  config(0).scan_marker = true;
  begin();
  controller::AxisReport line;
  line.state = AxisState::tracking;
  line.point.scan = controller::ScanPlace{.line = 3};
  axes_[0]->scan_marker_sender->note(line, 7);
  EXPECT_EQ(at(100), (Sent{"marker of x", "heartbeat"}));
  EXPECT_EQ(at(101), Sent{"status of x"});
}

TEST_F(Background, StartsTheNodesOfAWaitingAxisOnceInAPeriod) {
  begin();
  hear(axes_[0]->sensor, NmtState::pre_operational);
  hear(axes_[0]->amplifier, NmtState::pre_operational);
  hear(axes_[1]->sensor, NmtState::pre_operational);
  EXPECT_EQ(at(1), Sent{}) << "no axis waits";
  wait(0);
  EXPECT_EQ(at(2), Sent{"start 2"});
  EXPECT_EQ(at(3), Sent{"start 1"});
  EXPECT_EQ(at(4), Sent{}) << "y does not wait";
  EXPECT_EQ(at(100), (Sent{"heartbeat", "start 2"})) << "the nodes come before the statuses";
}

TEST_F(Background, LetsStatusesAndTheStartUpTakeTurns) {
  begin();
  hear(axes_[0]->sensor, NmtState::pre_operational);
  hear(axes_[0]->amplifier, NmtState::pre_operational);
  wait(0);
  EXPECT_EQ(at(100), (Sent{"heartbeat", "start 2"}));
  EXPECT_EQ(at(101), Sent{"status of x"});
  EXPECT_EQ(at(102), Sent{"start 1"});
  EXPECT_EQ(at(103), Sent{"status of y"});
}

TEST_F(Background, SendsAStatusIfTheNodesNeedNothing) {
  begin();
  for (controller::RemoteNode* node : axes_[0]->nodes()) hear(*node, NmtState::operational);
  wait(0);
  EXPECT_EQ(at(100), (Sent{"heartbeat", "status of x"}));
  EXPECT_EQ(at(101), Sent{"status of y"});
}

TEST_F(Background, SendsANewStateBeforeTheStartUpBetweenHeartbeats) {
  begin();
  hear(axes_[0]->sensor, NmtState::pre_operational);
  axes_[0]->axis.start(false);
  axes_[0]->axis.step({});
  EXPECT_EQ(at(1), Sent{"status of x"});
  EXPECT_EQ(at(2), Sent{"start 2"});
}

TEST_F(Background, DoesNotStartAnOperationalNode) {
  begin();
  hear(axes_[0]->sensor, NmtState::operational);
  hear(axes_[0]->amplifier, NmtState::pre_operational);
  wait(0);
  EXPECT_EQ(at(1), Sent{"start 1"}) << "in the same cycle, not the one after";
}

TEST_F(Background, SetsUpANodeBeforeTheStart) {
  config(0).wire.amplifier_setup = one_object();
  begin();
  hear(axes_[0]->sensor, NmtState::operational);
  hear(axes_[0]->amplifier, NmtState::pre_operational);
  wait(0);
  EXPECT_EQ(at(1), Sent{"601"});
  EXPECT_EQ(at(2), Sent{}) << "the answer is waited for";
  answer_set_up(axes_[0]->amplifier);
  EXPECT_EQ(at(3), Sent{}) << "the node had its turn of this period";
  EXPECT_EQ(at(100), (Sent{"heartbeat", "start 1"}));
}

TEST_F(Background, SendsAStoppedNodeToPreOperationalBeforeItsSetUp) {
  config(0).wire.amplifier_setup = one_object();
  begin();
  hear(axes_[0]->sensor, NmtState::stopped);
  hear(axes_[0]->amplifier, NmtState::stopped);
  wait(0);
  EXPECT_EQ(at(1), Sent{"start 2"}) << "there is nothing to set up";
  EXPECT_EQ(at(2), Sent{"enter pre-operational 1"});
}

TEST_F(Background, SetsTheNodesOfWaitingAxesUpInTurn) {
  for (auto& axis : setup_.controller.axes) axis.wire.sensor_setup = axis.wire.amplifier_setup = one_object();
  begin();
  for (const auto& wired : axes_)
    for (controller::RemoteNode* node : wired->nodes()) hear(*node, NmtState::pre_operational);
  wait(1);
  EXPECT_EQ(at(1), Sent{"604"});
  EXPECT_EQ(at(2), Sent{"603"});
  EXPECT_EQ(at(3), Sent{}) << "x does not wait";
  wait(0);
  EXPECT_EQ(at(4), Sent{"602"});
  EXPECT_EQ(at(5), Sent{"601"});
}

TEST_F(Background, FindsTheNodeForSetUpInOneCycle) {
  config(1).wire.amplifier_setup = one_object();
  begin();
  hear(axes_[1]->amplifier, NmtState::pre_operational);
  wait(1);
  EXPECT_EQ(at(1), Sent{"603"});
}

TEST_F(Background, FaultsTheAxesThatWaitForANodeThatCannotBeSetUp) {
  config(0).wire.amplifier_setup = one_object();
  config(0).wire.setup_patience.attempts = 1;
  config(1).wire.amplifier_node = 1;  // a shared node, set up by axis x
  begin();
  for (const auto& wired : axes_) hear(wired->amplifier, NmtState::pre_operational);
  wait(0);
  EXPECT_EQ(at(1), Sent{"601"});
  axes_[0]->amplifier.on_sdo(can::sdo_response(
      1, {.object = one_object()[0].object, .content = {.value = can::sdo_abort::no_such_object}}));
  for (int ms = 2; ms < 10; ++ms) at(ms);
  EXPECT_EQ(axes_[0]->axis.fault().cause, controller::Cause::node_not_set_up);
  EXPECT_EQ(axes_[1]->axis.state(), AxisState::offline) << "it does not wait";
}

TEST_F(Background, StartsASharedNodeWhenEveryAxisHasItSetUp) {
  config(0).wire.amplifier_setup = one_object();
  config(1).wire.amplifier_node = 1;
  begin();
  for (const auto& wired : axes_) {
    hear(wired->amplifier, NmtState::pre_operational);
    hear(wired->sensor, NmtState::operational);
  }
  wait(1);
  EXPECT_EQ(at(1), Sent{"601"}) << "although x, which has its objects, does not wait";
  EXPECT_EQ(at(2), Sent{});
  EXPECT_EQ(at(100), (Sent{"heartbeat", "status of x"})) << "it is not started";
  answer_set_up(axes_[0]->amplifier);
  EXPECT_EQ(at(200), (Sent{"heartbeat", "start 1"}));
}

TEST_F(Background, KeepsTheSlotOfTheController) {
  begin(24);
  EXPECT_EQ(in_slot(9, 99), Sent{});
  EXPECT_EQ(in_slot(10, 99), Sent{});
  EXPECT_EQ(in_slot(33, 100), Sent{});
  EXPECT_EQ(in_slot(34, 101), Sent{"heartbeat"});
  EXPECT_EQ(in_slot(35, 102), Sent{});
  EXPECT_EQ(in_slot(58, 103), Sent{"status of x"});
  EXPECT_EQ(in_slot(82, 104), Sent{"status of y"});
  EXPECT_EQ(in_slot(106, 105), Sent{});
}

TEST_F(Background, SendsAMarkerInItsSlotBeforeAnyStatus) {
  config(0).scan_marker = true;
  begin(24);
  EXPECT_EQ(in_slot(10, 100), Sent{"heartbeat"});
  controller::AxisReport line;
  line.state = AxisState::tracking;
  line.point.scan = controller::ScanPlace{.line = 3};
  axes_[0]->scan_marker_sender->note(line, 7);
  EXPECT_EQ(in_slot(34, 101), Sent{"marker of x"});
  EXPECT_EQ(in_slot(58, 102), Sent{"status of x"});
}

TEST_F(Background, SendsOnlyTheStartUpAfterTheCommandsWithSlots) {
  begin(24);
  hear(axes_[0]->sensor, NmtState::pre_operational);
  wait(0);
  EXPECT_EQ(at(100), Sent{"start 2"});
  EXPECT_EQ(at(101), Sent{"start 1"}) << "also a node that has not been heard";
  EXPECT_EQ(at(102), Sent{});
}

TEST_F(Background, SendsNothingAfterTheSyncWithoutSlots) {
  begin();
  EXPECT_EQ(in_slot(10, 100), Sent{});
}

}  // namespace
}  // namespace hystcan::background_frames_test
