// The twin's two nodes observed at the bus: every test uses only frames.
#include <gtest/gtest.h>

#include "tests/support/shows.h"
#include "tests/twin/twin_bench.h"

namespace hystcan::twin::nodes_test {
namespace {

using can::AmpState;
using std::chrono::milliseconds;

class TwinOnBus : public testing::Test, protected TwinBench {};

TEST_F(TwinOnBus, SendsBootUpAndPreOperationalHeartbeatsUntilStarted) {
  shows("S-096");
  run(milliseconds(250));
  EXPECT_EQ(amplifier_heartbeats_, (std::vector<int>{0x00, 0x7F, 0x7F}));
  EXPECT_EQ(heard_[0x702], 3);
  start_nodes();
  run(milliseconds(100));
  EXPECT_EQ(amplifier_heartbeats_.back(), 0x05);
}

TEST_F(TwinOnBus, AnswersEverySyncWithOneSampleOnceStarted) {
  shows("S-147");
  cycle();
  EXPECT_EQ(heard_[0x182], 0) << "pre-operational";
  start_nodes();
  for (int i = 0; i < 250; ++i) {  // beyond the counter's wrap at 240
    cycle();
    ASSERT_TRUE(sample_);
    ASSERT_EQ(sample_->sync_counter, counter_);
  }
  EXPECT_EQ(heard_[0x182], 250);
}

TEST_F(TwinOnBus, AppliesASetpointAtTheNextSync) {
  shows("S-083");
  start_nodes();
  sync();
  command(50.0, true);
  run(milliseconds(2));
  EXPECT_EQ(output(), 0.0);
  sync();
  EXPECT_NEAR(output(), 50.0, 1e-3);
}

TEST_F(TwinOnBus, CountsAndIgnoresDamagedCommands) {
  shows("S-078, S-111");
  start_nodes();
  sync();
  can::Frame damaged = *encode_command_({.setpoint = 90.0, .enable = true, .sync_counter = counter_});
  damaged.data[0] ^= 0x10;
  tester_->send(damaged);
  can::Frame extended = *encode_command_({.setpoint = 90.0, .enable = true, .sync_counter = counter_});
  extended.extended = true;
  tester_->send(extended);
  can::Frame shorter = *encode_command_({.setpoint = 90.0, .enable = true, .sync_counter = counter_});
  shorter.length = 7;
  tester_->send(shorter);
  run(milliseconds(5));
  const can::E2eChecker& checker = twin_.axes().front()->amplifier.node().checker();
  EXPECT_EQ(checker.rejected(can::Rejection::wrong_crc), 1u);
  EXPECT_EQ(checker.rejected(can::Rejection::extended_id), 1u);
  EXPECT_EQ(checker.rejected(can::Rejection::wrong_length), 1u);
  EXPECT_EQ(status_->state, AmpState::ready);
}

TEST_F(TwinOnBus, IsSafeIfStoppedByNmt) {
  shows("S-084");
  start_nodes();
  drive(50.0, 20);
  tester_->send(can::nmt_frame({can::NmtCommand::stop, 1}));
  run(milliseconds(1));
  EXPECT_EQ(status_->state, AmpState::off);
  EXPECT_NEAR(output(), 0.0, 1e-3);
}

TEST_F(TwinOnBus, ResetsItsObjectsAtAReset) {
  constexpr can::SdoObject object{.index = 0x2001, .subindex = 1};
  tester_->send(can::sdo_request(
      1, {.service = can::SdoService::write, .object = object, .content = {.value = 140, .bytes = 2}}));
  run(milliseconds(1));
  const can::SdoServer& objects = twin_.axes().front()->amplifier.node().objects();
  ASSERT_EQ(objects.object(object)->value, 140u);
  tester_->send(can::nmt_frame({can::NmtCommand::stop, 1}));
  tester_->send(can::nmt_frame({can::NmtCommand::enter_pre_operational, 1}));
  run(milliseconds(1));
  EXPECT_TRUE(objects.object(object)) << "other NMT commands do not reset the objects";
  tester_->send(can::nmt_frame({can::NmtCommand::reset_node, 2}));
  run(milliseconds(1));
  EXPECT_TRUE(objects.object(object)) << "a reset of another node changes nothing";
  tester_->send(can::nmt_frame({can::NmtCommand::reset_node, 1}));
  run(milliseconds(1));
  EXPECT_FALSE(objects.object(object));
}

}  // namespace
}  // namespace hystcan::twin::nodes_test
