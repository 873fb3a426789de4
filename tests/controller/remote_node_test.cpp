#include "controller/remote_node.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

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

TEST_F(NodeEight, MaySendInItsSlotOrOneCycleLater) {
  come_after({8, 32, 33, 9, 224, 225, 8});
  EXPECT_EQ(node.outside_slot(), 0U);
  EXPECT_FALSE(node.take_event());
}

TEST_F(NodeEight, IsReportedOnceForThreeMoreFramesOutsideThanWithin) {
  come_after({10, 7, 8, 12});
  EXPECT_FALSE(node.take_event());
  come_after({65, 10, 12});
  const auto event = node.take_event();
  ASSERT_TRUE(event);
  EXPECT_EQ(
      describe(*event),
      "node 8: heartbeats or statuses of this node arrive outside its slot 8 of 24, the last frame in slot "
      "17: set background_slots = 24 in the node, as in the controller, otherwise commands may be late");
  EXPECT_FALSE(node.take_event());
  EXPECT_EQ(node.outside_slot(), 6U);
}

TEST_F(NodeEight, GetsNoCreditForEarlierFramesWithinItsSlot) {
  come_after({8, 32, 8, 10, 7});
  EXPECT_FALSE(node.take_event());
  come_after({12});
  EXPECT_TRUE(node.take_event());
}

TEST_F(NodeEight, IsNotReportedForOccasionalDelays) {
  for (int i = 0; i < 5; ++i) come_after({10, 11, 8, 32});
  EXPECT_FALSE(node.take_event());
  EXPECT_EQ(node.outside_slot(), 0U);
}

TEST(NodeWithTheLastSlot, MaySendAtTheLastSyncOrTheFirst) {
  RemoteNode node{24, std::chrono::milliseconds(300), {24, {}, {}}};
  for (const int sync : {240, 1, 24, 25}) node.note_background_frame(static_cast<std::uint8_t>(sync), slots);
  EXPECT_EQ(node.outside_slot(), 0U);
  for (const int sync : {2, 239, 23}) node.note_background_frame(static_cast<std::uint8_t>(sync), slots);
  EXPECT_EQ(node.outside_slot(), 3U);
}

TEST(HeartbeatOfANode, IsUnchangedOnlyIfTheStateIsEqual) {
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

TEST(NmtOfAnotherNode, IncludesThisNodeIfAddressedToAll) {
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

TEST(EmergencyOfANode, IsAnAlarmUnlessItsCodeMeansNoError) {
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

TEST(SdoOfAnotherNode, IsCountedByServiceAndOnlyWritesChangeTheNode) {
  RemoteNode node{8, std::chrono::milliseconds(300), {8, {}, {}}};
  const can::SdoObject object{.index = 0x2001, .subindex = 2};
  const can::Frame write = can::sdo_request(8, {.service = can::SdoService::write, .object = object});
  const can::Frame read = can::sdo_request(8, {.service = can::SdoService::read, .object = object});
  can::Frame next_segment = read;
  next_segment.data[0] = 0x60;  // of a read in progress
  EXPECT_TRUE(node.on_foreign_sdo(write));
  EXPECT_TRUE(node.on_foreign_sdo(write));
  EXPECT_FALSE(node.on_foreign_sdo(read));
  EXPECT_FALSE(node.on_foreign_sdo(next_segment));
  node.on_foreign_nmt(can::nmt_frame({can::NmtCommand::start, 8}));
  EXPECT_EQ(describe(node.foreign_access()), "1 NMT command, 2 SDO writes, 1 SDO read of another node");
  EXPECT_EQ(describe(ForeignAccess{}), "");
}

TEST(AnotherController, IsNamedByItsFrameAndFullIdentifier) {
  using Kind = ForeignFrame::Kind;
  const auto said = [](const ForeignFrame& frame) {
    return describe(NodeEvent{.kind = NodeEvent::Kind::another_controller, .frame = frame});
  };
  EXPECT_EQ(said({.kind = Kind::sync, .id = 0x80}), "another node sends SYNC (0x080)");
  EXPECT_EQ(said({.kind = Kind::heartbeat, .id = 0x70A}),
            "another node sends the heartbeat of this controller (0x70A)");
  EXPECT_EQ(said({.kind = Kind::command, .id = 0x201, .extended = true}),
            "another node sends a command to an amplifier (0x00000201)");
  EXPECT_EQ(said({.kind = Kind::axis_status, .id = 0x281}),
            "another node sends a controller's status of an axis (0x281)");
}

class SetUpOfANode : public testing::Test {
 protected:
  std::optional<can::Frame> polled_after(can::NmtState state) {
    node.on_heartbeat(can::heartbeat_frame(8, state), {});
    return node.poll_setup({});
  }
  void refuse() {
    node.on_sdo(
        can::sdo_response(8, {.object = object, .content = {.value = can::sdo_abort::no_such_object}}));
    node.poll_setup({});
  }
  static constexpr can::SdoObject object{.index = 0x2001, .subindex = 2};
  RemoteNode node{8, std::chrono::milliseconds(300), {8, {{object, {.value = 5}}}, {.attempts = 1}}};
};

TEST_F(SetUpOfANode, BeginsWithAHeartbeatExceptInAStoppedNode) {
  EXPECT_FALSE(node.poll_setup({}));
  EXPECT_FALSE(polled_after(can::NmtState::stopped));
  EXPECT_TRUE(polled_after(can::NmtState::pre_operational));
}

TEST_F(SetUpOfANode, ReportsEachFailureOnce) {
  ASSERT_TRUE(polled_after(can::NmtState::pre_operational));
  refuse();
  for (int i = 0; i < 3; ++i) node.poll_setup({});
  const auto event = node.take_event();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->kind, NodeEvent::Kind::not_set_up);
  EXPECT_EQ(event->times, 1U);
  EXPECT_FALSE(node.take_event());
  node.retry_setup();
  ASSERT_TRUE(node.poll_setup({}));
  refuse();
  EXPECT_TRUE(node.take_event());
}

TEST_F(SetUpOfANode, IsLostWhenTheNodeIsReset) {
  ASSERT_TRUE(polled_after(can::NmtState::pre_operational));
  node.on_sdo(can::sdo_response(8, {.service = can::SdoService::written, .object = object}));
  ASSERT_TRUE(node.poll_setup({}));
  node.on_sdo(
      can::sdo_response(8, {.service = can::SdoService::value, .object = object, .content = {.value = 5}}));
  ASSERT_TRUE(node.is_set_up());
  node.forget();
  EXPECT_FALSE(node.is_set_up());
}

TEST(EventsOfANode, AreMergedAndCountedIfRepeated) {
  RemoteNode node{8, std::chrono::milliseconds(300), {8, {}, {}}};
  for (const std::uint16_t code :
       std::array<std::uint16_t, 6>{0x2310, 0x2310, 0x3110, 0x2310, 0x2310, 0x2310})
    node.on_emergency(can::emergency_frame(8, {.code = code}));
  const auto taken = [&] {
    const auto event = node.take_event().value_or(NodeEvent{.times = 0});
    return std::pair(static_cast<unsigned>(event.emergency.code), event.times);
  };
  EXPECT_EQ(taken(), std::pair(0x2310U, 2U));
  EXPECT_EQ(taken(), std::pair(0x3110U, 1U));
  EXPECT_EQ(taken(), std::pair(0x2310U, 3U));
  EXPECT_FALSE(node.take_event());
}

}  // namespace
}  // namespace hystcan::controller::remote_node_test
