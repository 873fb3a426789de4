// Two controllers or two twins on one bus: the second one does no harm, and the disturbed one reports it.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"
#include "tests/support/shows.h"

namespace hystcan::two_of_a_kind_test {
namespace {

using controller::AxisState;
using controller::Cause;
using controller::Controller;
using std::chrono::milliseconds;

/// A rehearsal of the shipped stage with a foreign node on its bus.
struct SharedBus : testing::Test {
  SharedBus() { rehearsal.start(); }

  void track() {
    rehearsal.run_for(std::chrono::seconds(2));
    ASSERT_EQ(loop.axis(0).state(), AxisState::tracking);
    ASSERT_EQ(loop.axis(1).state(), AxisState::tracking);
  }
  void expect_faulted(const Controller& controller) {
    for (std::size_t i = 0; i < controller.axis_count(); ++i) {
      EXPECT_EQ(controller.axis(i).state(), AxisState::faulted);
      EXPECT_EQ(controller.axis(i).fault().cause, Cause::another_controller);
    }
  }
  bool amplifiers_are_off() {
    for (const auto& axis : rehearsal.twin().axes())
      if (axis->amplifier.state() == can::AmpState::enabled) return false;
    return true;
  }
  void send(const can::Frame& frame) {
    foreign_node->send(frame);
    rehearsal.run_for(milliseconds(2));
  }

  const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  std::vector<std::string> events;  ///< events for the log
  rehearsal::Rehearsal rehearsal{support::setup_of(config), [this](const controller::CycleRecord& record) {
                                   if (record.event) events.push_back(describe(*record.event));
                                 }};
  Controller& loop = rehearsal.controller();
  std::unique_ptr<can::Bus> foreign_node = rehearsal.attach()({});
};

struct SecondController : SharedBus {
  std::vector<controller::CycleRecord> records;
  std::optional<Controller> second;

  void start_second() {
    second.emplace(controller_config(config), config.database, rehearsal.clock(), rehearsal.attach(),
                   [this](const controller::CycleRecord& record) { records.push_back(record); });
    second->start();
  }
};

TEST_F(SecondController, FaultsBeforeItSendsAnyFrameAndTheFirstKeepsTracking) {
  shows("S-156");
  track();
  start_second();
  rehearsal.run_for(milliseconds(5));
  expect_faulted(*second);
  EXPECT_TRUE(second->keeps_silent());
  EXPECT_TRUE(second->stopped());
  second->send_safe_commands();
  rehearsal.run_for(std::chrono::seconds(1));
  EXPECT_EQ(second->bus().counters().sent, 0u) << "not even a safe command";
  EXPECT_EQ(loop.axis(0).state(), AxisState::tracking);
  EXPECT_EQ(loop.axis(1).state(), AxisState::tracking);
  ASSERT_EQ(records.size(), 2u) << "one cycle record for each axis goes to the log";
  EXPECT_EQ(records[0].report.cause, Cause::another_controller);
  EXPECT_EQ(to_string(records[0].report.cause), "another controller is on this bus");
}

TEST_F(SecondController, FaultsBothBeforeTheyArmWhenStartedAtTheSameInstant) {
  start_second();
  rehearsal.run_for(std::chrono::seconds(2));
  expect_faulted(*second);
  expect_faulted(loop);
  EXPECT_TRUE(amplifiers_are_off());
}

TEST_F(SharedBus, IsListenedToForAHeartbeatPeriodBeforeTheFirstSync) {
  shows("S-149");
  std::vector<can::Time> syncs;
  foreign_node->on_frame([&](const can::Frame& frame, can::Time received) {
    if (frame.id == can::sync_id) syncs.push_back(received);
  });
  rehearsal.run_for(milliseconds(110));
  ASSERT_FALSE(syncs.empty());
  EXPECT_GE(syncs.front(), can::Time(config.controller.heartbeat_period));
  EXPECT_LT(syncs.front(), can::Time(config.controller.heartbeat_period + milliseconds(1)));
}

struct ForeignFrame {
  const char* name;
  can::Frame (*made)(const can::Database& database);
  const char* text;  ///< expected text in the log

  friend void PrintTo(const ForeignFrame& frame, std::ostream* out) { *out << frame.name; }
};

struct AnotherController : SharedBus, testing::WithParamInterface<ForeignFrame> {};

TEST_P(AnotherController, FaultsEveryAxisByItsFrameWhichIsNamed) {
  shows("S-154");
  track();
  send(GetParam().made(config.database));
  expect_faulted(loop);
  EXPECT_EQ(events, (std::vector<std::string>{GetParam().text, GetParam().text}));
}

using Database = can::Database;
INSTANTIATE_TEST_SUITE_P(
    Sends, AnotherController,
    testing::Values(ForeignFrame{"Sync", [](const Database&) { return can::sync_frame(7); },
                                 "another node sends SYNC (0x080)"},
                    ForeignFrame{"SyncWithoutACounter",
                                 [](const Database&) { return can::Frame{.id = can::sync_id, .length = 0}; },
                                 "another node sends SYNC (0x080)"},
                    ForeignFrame{
                        "Heartbeat",
                        [](const Database&) { return can::heartbeat_frame(127, can::NmtState::operational); },
                        "another node sends the heartbeat of this controller (0x77F)"},
                    ForeignFrame{"Command",
                                 [](const Database& database) {
                                   return *can::Encoder<can::AmpCommand>(*database.find("YAmpCommand"))(
                                       {.setpoint = 20.0, .enable = true, .sync_counter = 1});
                                 },
                                 "another node sends a command to an amplifier (0x203)"},
                    ForeignFrame{"Status",
                                 [](const Database& database) {
                                   return *can::Encoder<can::ControllerStatus>(
                                       *database.find("XControllerStatus"))({.state = 1});
                                 },
                                 "another node sends a controller's status of an axis (0x281)"}),
    [](const auto& test) { return test.param.name; });

TEST_F(SharedBus, MalformedForeignFramesDoNotDisturbTracking) {
  shows("S-157");
  track();
  send({.id = 0x080, .length = 1, .data = {0}});  // the counter runs from 1 to 240
  send({.id = 0x080, .length = 2, .data = {1}});
  send({.id = 0x080, .extended = true, .length = 1, .data = {1}});
  send({.id = 0x77F, .length = 1, .data = {0x11}});  // not a state of CiA 301
  send({.id = 0x77F, .length = 2, .data = {0x05}});
  send({.id = 0x203, .length = 8});  // no CRC
  send({.id = 0x283, .length = 8});
  send({.id = 0x201, .extended = true, .length = 8});
  EXPECT_EQ(loop.axis(0).state(), AxisState::tracking);
  EXPECT_EQ(loop.axis(1).state(), AxisState::tracking);
}

TEST_F(SharedBus, ASecondTwinDetectsTheFirstAndStaysSilent) {
  shows("S-156");
  track();
  twin::Twin second(twin_config(config), config.database, rehearsal.clock(), rehearsal.attach());
  second.start();
  rehearsal.run_for(std::chrono::seconds(1));
  EXPECT_TRUE(second.station().taken_node());
  for (const can::Bus* bus : second.station().connections()) EXPECT_EQ(bus->counters().sent, 0u);
  EXPECT_FALSE(rehearsal.twin().station().taken_node());
  EXPECT_EQ(loop.axis(0).state(), AxisState::tracking);
}

TEST_F(SharedBus, ATwinNodeIsOffAndSilentIfItsNumberIsTaken) {
  shows("S-155");
  track();
  send(can::heartbeat_frame(1, can::NmtState::operational));
  EXPECT_EQ(rehearsal.twin().station().taken_node(), 1);
  EXPECT_EQ(rehearsal.twin().axes()[0]->amplifier.state(), can::AmpState::off);
  const std::uint64_t sent = rehearsal.twin().station().connections()[0]->counters().sent;
  rehearsal.run_for(std::chrono::seconds(1));
  EXPECT_EQ(rehearsal.twin().station().connections()[0]->counters().sent, sent);
  EXPECT_EQ(loop.axis(0).state(), AxisState::faulted) << "the stage no longer follows, or the node is silent";
}

}  // namespace
}  // namespace hystcan::two_of_a_kind_test
