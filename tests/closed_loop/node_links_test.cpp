// What an axis knows of its two nodes, frame by frame and without a bus: what counts, and what is forgotten.
#include <gtest/gtest.h>

#include <chrono>

#include "config/schema/config.h"
#include "controller/wired_axis.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/lone_axis.h"
#include "tests/support/rehearsed.h"
#include "tests/support/shows.h"

namespace hystcan::node_links_test {
namespace {

using can::BusState;
using can::NmtState;

class AxisOfTheStage : public testing::Test {
 protected:
  AxisOfTheStage() {
    wire().frames = can::AxisFrames{.command = *can::message_map<can::AmpCommand>(wire()),
                                    .status = can::message_map<can::AmpStatus>(wire()),
                                    .sample = *can::message_map<can::SensorSample>(wire())};
  }
  can::AxisWire& wire() { return setup_.controller.axes[0].wire; }
  can::AxisFrames& frames() { return *wire().frames; }
  support::LoneAxis axis() const { return {setup_.controller.axes[0], setup_.database}; }
  /// The next sample of a sensor that has just started.
  can::Frame first_sample(std::uint8_t sync_counter, double position_um) {
    return *can::Encoder<can::SensorSample>(*can::find_layout<can::SensorSample>(setup_.database, wire()))(
        {.position_um = position_um, .sync_counter = sync_counter});
  }

  rehearsal::Setup setup_ = support::shipped("piezo.toml");
};
using Amplifier = AxisOfTheStage;
using Sensor = AxisOfTheStage;
using BusLoss = AxisOfTheStage;

TEST_F(Amplifier, CausesAnAlarmByItsEmergencyOnce) {
  support::LoneAxis lone = axis();
  lone.wired.amplifier.on_emergency(can::emergency_frame(1, {.code = 0x2310}));
  EXPECT_TRUE(lone.health().emergency);
  EXPECT_FALSE(lone.health().emergency) << "it counts for one step";
}

TEST_F(Amplifier, IsInFaultByItsFaultFieldWhereNoStateReportsAFault) {
  frames().status->states.fault.clear();
  support::LoneAxis lone = axis();
  lone.hear_status({.state = can::AmpState::enabled});
  EXPECT_FALSE(lone.health().amplifier_fault);
  lone.hear_status({.state = can::AmpState::enabled, .fault = 0x01});
  EXPECT_TRUE(lone.health().amplifier_fault);
}

TEST_F(Amplifier, IsInFaultByItsFaultFieldWhereThereIsNoState) {
  frames().status->signals.erase("state");
  support::LoneAxis lone = axis();
  lone.hear_status({});
  EXPECT_FALSE(lone.health().amplifier_fault);
  lone.hear_status({.fault = 0x01});
  EXPECT_TRUE(lone.health().amplifier_fault);
}

TEST_F(Sensor, WithoutACounterMaySendAFrameTwiceButNotTwoDifferentOnesForASync) {
  shows("S-006");
  frames().sample.integrity = can::Integrity::none;
  support::LoneAxis lone = axis();
  controller::SensorLink& sensor = lone.wired.sensor;
  ASSERT_TRUE(sensor.on_sample(first_sample(7, 10.0), 7));
  ASSERT_TRUE(sensor.on_sample(first_sample(7, 10.0), 7));
  EXPECT_FALSE(sensor.is_doubled());
  ASSERT_TRUE(sensor.on_sample(first_sample(7, 11.0), 7));
  EXPECT_TRUE(sensor.is_doubled());
}

TEST_F(Sensor, MayBeginWithAnyCounterAfterItsBootUp) {
  shows("S-080");
  support::LoneAxis lone = axis();
  controller::SensorLink& sensor = lone.wired.sensor;
  ASSERT_TRUE(sensor.on_sample(first_sample(1, 10.0), 1));
  ASSERT_FALSE(sensor.on_sample(first_sample(2, 10.0), 2)) << "the counter is repeated";
  sensor.on_heartbeat(can::heartbeat_frame(2, NmtState::boot_up), {});
  EXPECT_TRUE(sensor.on_sample(first_sample(3, 10.0), 3));
}

TEST_F(BusLoss, IsFollowedByWaitingForTheHeartbeatsOfBothNodes) {
  shows("S-169");
  support::LoneAxis lone = axis();
  lone.wired.amplifier.on_heartbeat(can::heartbeat_frame(1, NmtState::operational), {});
  lone.wired.sensor.on_heartbeat(can::heartbeat_frame(2, NmtState::operational), {});
  ASSERT_TRUE(lone.wired.amplifier.is_operational({}));
  ASSERT_TRUE(lone.wired.sensor.is_operational({}));
  lone.wired.amplifier.on_bus_loss(BusState::bus_off);
  lone.wired.sensor.on_bus_loss();
  EXPECT_FALSE(lone.wired.amplifier.state({}));
  EXPECT_FALSE(lone.wired.sensor.state({}));
}

TEST_F(BusLoss, LeavesNoStatusOfTheAmplifierAndNoCounterOfEitherNode) {
  shows("S-080, S-169");
  support::LoneAxis lone = axis();
  can::Encoder<can::AmpStatus> encode(*can::find_layout<can::AmpStatus>(setup_.database, wire()));
  const can::Frame status = *encode({.output = 50.0, .state = can::AmpState::enabled});
  lone.wired.amplifier.on_status(status, {});
  ASSERT_TRUE(lone.wired.sensor.on_sample(first_sample(1, 10.0), 1));
  ASSERT_EQ(lone.wired.amplifier.output(), 50.0);
  lone.wired.amplifier.on_bus_loss(BusState::bus_off);
  lone.wired.sensor.on_bus_loss();
  EXPECT_FALSE(lone.health().amplifier_enabled);
  EXPECT_EQ(lone.wired.amplifier.output(), 0.0);
  EXPECT_TRUE(lone.wired.sensor.on_sample(first_sample(2, 10.0), 2));
  lone.wired.amplifier.on_status(status, {});
  EXPECT_EQ(lone.wired.amplifier.output(), 50.0);
}

TEST_F(BusLoss, LeavesNoCommandThatWaitsForTheEchoOfTheOneBefore) {
  shows("S-169");
  can::VirtualClock clock;
  can::SimBus bus(clock, {1'000'000});
  const auto connection = bus.attach();
  support::LoneAxis lone = axis();
  controller::AmplifierLink& amplifier = lone.wired.amplifier;
  amplifier.commands().begin_to_count_echoes();
  for (std::uint8_t sync = 1; sync <= 2; ++sync) {
    amplifier.put(controller::AxisCommand{.drive = 10.0, .enable = true}, sync);
    amplifier.commands().send(*connection);
  }
  ASSERT_TRUE(lone.health().commands_late);
  amplifier.on_bus_loss(BusState::bus_off);
  EXPECT_FALSE(lone.health().commands_late);
}

TEST(StopRequest, StopsTheAxesThatItDoesNotName) {
  controller::RequestLink requests;
  rehearsal::Rehearsal rehearsal(support::shipped("piezo.toml"), support::ignore);
  rehearsal.controller().listen_to(requests);
  rehearsal.start();
  rehearsal.run_for(std::chrono::seconds(2));
  ASSERT_EQ(rehearsal.controller().axis(1).state(), controller::AxisState::tracking);
  auto stop = std::make_unique<controller::Request>();
  stop->kind = controller::Request::Kind::stop;
  ASSERT_TRUE(requests.ask(std::move(stop)));
  rehearsal.run_for(std::chrono::seconds(2));
  EXPECT_EQ(rehearsal.controller().axis(0).state(), controller::AxisState::offline);
  EXPECT_EQ(rehearsal.controller().axis(1).state(), controller::AxisState::offline);
}

}  // namespace
}  // namespace hystcan::node_links_test
