#include "controller/remote_node.h"

#include <gtest/gtest.h>

namespace hystcan::controller::remote_node_test {
namespace {

constexpr unsigned slots = 24;

class BackgroundFrameOf : public testing::Test {
 protected:
  void come_after(std::initializer_list<int> syncs) {
    for (const int sync : syncs) node.note_background_frame(static_cast<std::uint8_t>(sync), slots);
  }
  RemoteNode node{8, std::chrono::milliseconds(300), {8, {}, {}}};
};
using NodeEight = BackgroundFrameOf;

TEST_F(NodeEight, IsInItsSlotOrInTheCycleAfterIt) {
  come_after({8, 32, 33, 9, 224, 225, 8});
  EXPECT_EQ(node.outside_slot(), 0U);
  EXPECT_FALSE(node.take_event());
}

TEST_F(NodeEight, IsNamedOnceWhenThreeMoreAreOutsideThanWithin) {
  come_after({10, 7, 8, 12});
  EXPECT_FALSE(node.take_event());
  come_after({65, 10, 12});
  const auto event = node.take_event();
  ASSERT_TRUE(event);
  EXPECT_EQ(describe(*event),
            "node 8: heartbeats or statuses come outside of its slot 8 of 24, the last one in slot 17: set "
            "background_slots in the node, or commands may be late");
  EXPECT_FALSE(node.take_event());
  EXPECT_EQ(node.outside_slot(), 6U);
}

TEST_F(NodeEight, IsNotNamedWhereABusyBusDelaysOneFrameAndThenAnother) {
  for (int i = 0; i < 5; ++i) come_after({10, 11, 8, 32});
  EXPECT_FALSE(node.take_event());
  EXPECT_EQ(node.outside_slot(), 0U);
}

TEST(NodeWithTheLastSlot, HasItAtTheLastSyncAndTheFirstOneAfterIt) {
  RemoteNode node{24, std::chrono::milliseconds(300), {24, {}, {}}};
  for (const int sync : {240, 1, 24, 25}) node.note_background_frame(static_cast<std::uint8_t>(sync), slots);
  EXPECT_EQ(node.outside_slot(), 0U);
  for (const int sync : {2, 239, 23}) node.note_background_frame(static_cast<std::uint8_t>(sync), slots);
  EXPECT_EQ(node.outside_slot(), 3U);
}

TEST(HeartbeatOfANode, IsAsBeforeOnlyWithTheStateOfTheLastOne) {
  using can::NmtState;
  RemoteNode node{8, std::chrono::milliseconds(300), {8, {}, {}}};
  const auto hear = [&](NmtState state, int ms) {
    return node.on_heartbeat(can::heartbeat_frame(8, state), can::Time{} + std::chrono::milliseconds(ms));
  };
  EXPECT_EQ(hear(NmtState::boot_up, 0), Heartbeat::boot_up);
  EXPECT_EQ(hear(NmtState::pre_operational, 100), Heartbeat::new_state);
  EXPECT_EQ(hear(NmtState::pre_operational, 200), Heartbeat::as_before);
  EXPECT_EQ(hear(NmtState::operational, 250), Heartbeat::new_state);
  EXPECT_EQ(hear(NmtState::operational, 900), Heartbeat::new_state) << "it was silent";
}

TEST(NmtOfAnotherNode, ToAllNodesIsAlsoToThisOne) {
  using can::NmtCommand;
  RemoteNode node{8, std::chrono::milliseconds(300), {8, {}, {}}};
  for (const NmtCommand command : {NmtCommand::stop, NmtCommand::enter_pre_operational,
                                   NmtCommand::reset_node, NmtCommand::reset_communication}) {
    EXPECT_TRUE(node.on_foreign_nmt(can::nmt_frame({command, 0}))) << to_string(command);
    EXPECT_TRUE(node.on_foreign_nmt(can::nmt_frame({command, 8}))) << to_string(command);
    EXPECT_FALSE(node.on_foreign_nmt(can::nmt_frame({command, 9}))) << to_string(command);
  }
  EXPECT_EQ(node.foreign_access().nmt, 8U);
}

TEST(EmergencyOfANode, IsAnAlarmUnlessItsCodeSaysThatThereIsNoError) {
  RemoteNode node{8, std::chrono::milliseconds(300), {8, {}, {}}};
  const auto alarms = [&](std::uint16_t code) {
    node.on_emergency(can::emergency_frame(8, {.code = code}));
    return node.take_alarm();
  };
  EXPECT_FALSE(alarms(0x0000));
  EXPECT_FALSE(alarms(0x00FF));
  EXPECT_TRUE(alarms(0x0100));
  EXPECT_TRUE(alarms(0x8130));
}

}  // namespace
}  // namespace hystcan::controller::remote_node_test
