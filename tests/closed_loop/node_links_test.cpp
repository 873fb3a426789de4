// The state that an axis keeps about its two nodes, frame by frame and without a bus: which frames count, and
// when the state is reset.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <set>

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
  /// Returns the next sample of a sensor that has just started.
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

TEST_F(Amplifier, IsFaultedByItsFaultFieldIfNoStateMeansFault) {
  frames().status->states.fault.clear();
  support::LoneAxis lone = axis();
  lone.hear_status({.state = can::AmpState::enabled});
  EXPECT_FALSE(lone.health().amplifier_fault);
  lone.hear_status({.state = can::AmpState::enabled, .fault = 0x01});
  EXPECT_TRUE(lone.health().amplifier_fault);
}

TEST_F(Amplifier, IsFaultedByItsFaultFieldIfThereIsNoState) {
  frames().status->signals.erase("state");
  support::LoneAxis lone = axis();
  lone.hear_status({});
  EXPECT_FALSE(lone.health().amplifier_fault);
  lone.hear_status({.fault = 0x01});
  EXPECT_TRUE(lone.health().amplifier_fault);
}

TEST_F(Amplifier, RestsAtItsSafeValueIfItReportsNoOutput) {
  EXPECT_TRUE(axis().health().output_reported);
  setup_.controller.axes[0].axis.gate.safe_drive = 5.0;
  frames().status->signals.erase("output");
  support::LoneAxis lone = axis();
  lone.hear_status({.state = can::AmpState::ready});
  EXPECT_FALSE(lone.health().output_reported) << "its output would differ from every drive";
  EXPECT_EQ(lone.wired.amplifier.output(), 5.0);
  EXPECT_FALSE(lone.health().amplifier_enabled);
}

TEST_F(Amplifier, GivesTheAgeOfItsOutputFromTheFirstStatusOn) {
  support::LoneAxis lone = axis();
  const can::Time later(std::chrono::milliseconds(8));
  EXPECT_TRUE(std::isnan(lone.wired.amplifier.output_age_s(later)));
  lone.hear_status({.output = 50.0});
  EXPECT_EQ(lone.wired.amplifier.output_age_s(later), 0.008);
}

TEST_F(Amplifier, IsEnabledIfItReportsNoState) {
  frames().status->signals.erase("state");
  support::LoneAxis lone = axis();
  lone.hear_status({.output = 50.0});
  EXPECT_TRUE(lone.health().amplifier_enabled);
  EXPECT_EQ(lone.wired.amplifier.output(), 50.0);
}

TEST_F(Amplifier, IsEnabledAtItsSafeValueIfItSendsNoStatus) {
  setup_.controller.axes[0].axis.gate.safe_drive = 5.0;
  frames().status.reset();
  support::LoneAxis lone = axis();
  const controller::NodeHealth health = lone.health(BusState::active, can::Time(std::chrono::hours(1)));
  EXPECT_TRUE(health.amplifier_enabled);
  EXPECT_EQ(health.amplifier_output, 5.0);
  EXPECT_EQ(health.status_age_s, 0.0);
}

TEST_F(Amplifier, MovesIfItsOutputChangesByOverAHundredthOfTheRange) {
  setup_.controller.axes[0].axis.gate.drive_min = -25.0;  // to 75 V: a range of 100 V
  setup_.controller.axes[0].axis.gate.drive_max = 75.0;
  support::LoneAxis lone = axis();
  const auto moves = [&](double output) {
    lone.hear_status({.output = output, .state = can::AmpState::ready});
    return lone.health().amplifier_moves;
  };
  EXPECT_TRUE(moves(50.0)) << "there is none to compare the first one with";
  EXPECT_FALSE(moves(50.0));
  EXPECT_FALSE(moves(51.0));
  EXPECT_TRUE(moves(52.01));
  EXPECT_FALSE(moves(51.02));
  EXPECT_TRUE(moves(50.01));
}

TEST_F(Amplifier, MovesFromACommandThatEnablesItUntilItsNextStatus) {
  support::LoneAxis lone = axis();
  const auto rest = [&] {
    lone.hear_status({.state = can::AmpState::ready});
    lone.hear_status({.state = can::AmpState::ready});
  };
  rest();
  lone.wired.amplifier.put(controller::AxisCommand{.drive = 0.0, .enable = false}, 1);
  EXPECT_FALSE(lone.health().amplifier_moves);
  lone.wired.amplifier.put(std::nullopt, 2);
  EXPECT_FALSE(lone.health().amplifier_moves);
  lone.wired.amplifier.put(controller::AxisCommand{.drive = 0.0, .enable = true}, 3);
  EXPECT_TRUE(lone.health().amplifier_moves);
  rest();
  EXPECT_FALSE(lone.health().amplifier_moves);
}

TEST_F(Amplifier, RepeatsAStatusIfItsStateIsUnchangedAndNotOff) {
  support::LoneAxis lone = axis();
  const auto repeats = [&](can::AmpState state) { return lone.hear_status({.state = state}); };
  EXPECT_FALSE(repeats(can::AmpState::off));
  EXPECT_FALSE(repeats(can::AmpState::ready));
  EXPECT_TRUE(repeats(can::AmpState::ready));
  EXPECT_FALSE(repeats(can::AmpState::enabled));
  EXPECT_TRUE(repeats(can::AmpState::enabled));
  EXPECT_FALSE(lone.hear_status_frame({.id = 0x181})) << "no status at all";
}

TEST_F(Sensor, MayRepeatAFrameButNotChangeItIfThereIsNoCounter) {
  shows("S-006");
  frames().sample.integrity = can::Integrity::none;
  support::LoneAxis lone = axis();
  controller::SensorLink& sensor = lone.wired.sensor;
  ASSERT_TRUE(lone.hear_sample(first_sample(7, 10.0), 7));
  ASSERT_TRUE(lone.hear_sample(first_sample(7, 10.0), 7));
  EXPECT_FALSE(sensor.is_doubled());
  ASSERT_TRUE(lone.hear_sample(first_sample(7, 11.0), 7));
  EXPECT_TRUE(sensor.is_doubled());
}

TEST_F(Sensor, IsNotDoubledByTheNextSample) {
  support::LoneAxis lone = axis();
  controller::SensorLink& sensor = lone.wired.sensor;
  can::Encoder<can::SensorSample> encode(*can::find_layout<can::SensorSample>(setup_.database, wire()));
  const auto hear = [&](std::uint8_t sync_counter, double position_um) {
    return lone.hear_sample(*encode({.position_um = position_um, .sync_counter = sync_counter}), 7)
        .has_value();
  };
  EXPECT_TRUE(hear(7, 10.0));
  EXPECT_FALSE(sensor.is_doubled());
  EXPECT_TRUE(hear(7, 11.0));
  EXPECT_TRUE(sensor.is_doubled());
  EXPECT_TRUE(hear(8, 10.0));
  EXPECT_FALSE(sensor.is_doubled());
}

TEST_F(Sensor, IsNeverDoubledIfItNamesNoSync) {
  frames().sample.signals.erase("sync_counter");
  frames().sample.integrity = can::Integrity::none;
  support::LoneAxis lone = axis();
  controller::SensorLink& sensor = lone.wired.sensor;
  ASSERT_TRUE(lone.hear_sample(first_sample(0, 10.0), 7));
  ASSERT_TRUE(lone.hear_sample(first_sample(0, 11.0), 7));
  EXPECT_FALSE(sensor.is_doubled());
}

TEST_F(Sensor, MayNameASyncAgainHalfARoundOfTheCounterLater) {
  frames().sample.integrity = can::Integrity::none;
  support::LoneAxis lone = axis();
  controller::SensorLink& sensor = lone.wired.sensor;
  lone.hear_sample(first_sample(7, 10.0), 1);
  lone.hear_sample(first_sample(7, 11.0), can::sync_counter_max / 2);
  EXPECT_TRUE(sensor.is_doubled());
  lone.hear_sample(first_sample(7, 12.0), can::sync_counter_max);
  EXPECT_FALSE(sensor.is_doubled());
}

TEST_F(Sensor, MayBeginWithAnyCounterAfterItsBootUp) {
  shows("S-080");
  support::LoneAxis lone = axis();
  controller::SensorLink& sensor = lone.wired.sensor;
  ASSERT_TRUE(lone.hear_sample(first_sample(1, 10.0), 1));
  ASSERT_FALSE(lone.hear_sample(first_sample(2, 10.0), 2)) << "the counter is repeated";
  sensor.on_heartbeat(can::heartbeat_frame(2, NmtState::boot_up), {});
  EXPECT_TRUE(lone.hear_sample(first_sample(3, 10.0), 3));
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

TEST_F(BusLoss, ClearsTheAmplifierStatusAndBothCounters) {
  shows("S-080, S-169");
  support::LoneAxis lone = axis();
  can::Encoder<can::AmpStatus> encode(*can::find_layout<can::AmpStatus>(setup_.database, wire()));
  const can::Frame status = *encode({.output = 50.0, .state = can::AmpState::enabled});
  lone.hear_status_frame(status);
  ASSERT_TRUE(lone.hear_sample(first_sample(1, 10.0), 1));
  ASSERT_EQ(lone.wired.amplifier.output(), 50.0);
  lone.wired.amplifier.on_bus_loss(BusState::bus_off);
  lone.wired.sensor.on_bus_loss();
  EXPECT_FALSE(lone.health().amplifier_enabled);
  EXPECT_EQ(lone.wired.amplifier.output(), 0.0);
  EXPECT_TRUE(lone.hear_sample(first_sample(2, 10.0), 2));
  lone.hear_status_frame(status);
  EXPECT_EQ(lone.wired.amplifier.output(), 50.0);
}

TEST_F(BusLoss, IsReportedInTheNextStepEvenIfBrief) {
  support::LoneAxis lone = axis();
  lone.wired.amplifier.on_bus_loss(BusState::bus_off);
  controller::NodeHealth health = lone.health();
  EXPECT_FALSE(health.bus_on);
  EXPECT_TRUE(health.interface_up);
  EXPECT_TRUE(lone.health().bus_on) << "it counts for one step";
  lone.wired.amplifier.on_bus_loss(BusState::down);
  health = lone.health();
  EXPECT_TRUE(health.bus_on);
  EXPECT_FALSE(health.interface_up);
  EXPECT_FALSE(lone.health(BusState::bus_off).bus_on) << "as long as it lasts";
  EXPECT_FALSE(lone.health(BusState::down).interface_up);
}

TEST_F(BusLoss, DropsCommandsThatWaitForAnEcho) {
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

using Frames = AxisOfTheStage;

TEST_F(Frames, ForLiveSetpointsAndMarkersExistOnlyIfConfigured) {
  EXPECT_FALSE(axis().wired.setpoint_receiver);
  EXPECT_FALSE(axis().wired.scan_marker_sender);
  setup_.controller.axes[0].live_setpoint = true;
  EXPECT_TRUE(axis().wired.setpoint_receiver);
  EXPECT_FALSE(axis().wired.scan_marker_sender);
  setup_.controller.axes[0].live_setpoint = false;
  setup_.controller.axes[0].scan_marker = true;
  EXPECT_FALSE(axis().wired.setpoint_receiver);
  EXPECT_TRUE(axis().wired.scan_marker_sender);
}

TEST_F(Frames, AreCountedByMessageIfRejected) {
  const auto messages = [&] {
    const support::LoneAxis lone = axis();
    std::vector<can::RejectedFrames> all;
    std::set<std::uint8_t> nodes;
    lone.wired.append_rejected(all, nodes);
    std::vector<std::string> names;
    for (const can::RejectedFrames& each : all) names.push_back(each.message);
    return names;
  };
  const std::vector<std::string> of_nodes = {"heartbeat of node 1",    "emergency of node 1",
                                             "SDO response of node 1", "heartbeat of node 2",
                                             "emergency of node 2",    "SDO response of node 2"};
  std::vector<std::string> expected = {"XSensorSample", "XAmpStatus"};
  expected.insert(expected.end(), of_nodes.begin(), of_nodes.end());
  EXPECT_EQ(messages(), expected);
  setup_.controller.axes[0].live_setpoint = true;
  expected.insert(expected.begin() + 2, "XSetpoint");
  EXPECT_EQ(messages(), expected);
}

using Events = AxisOfTheStage;

TEST_F(Events, AreTakenInTurnsOfTheNodes) {
  support::LoneAxis lone = axis();
  const auto emergency_of = [&](controller::RemoteNode& node) {
    node.on_emergency(can::emergency_frame(node.node(), {.code = 0x2310}));
    node.on_emergency(can::emergency_frame(node.node(), {.code = 0x3110}));
  };
  const auto taken = [&] {
    const auto event = lone.wired.take_event();
    return event ? static_cast<int>(event->node) : 0;
  };
  EXPECT_EQ(taken(), 0) << "there is none";
  emergency_of(lone.wired.amplifier);
  emergency_of(lone.wired.sensor);
  EXPECT_EQ(taken(), 1);
  EXPECT_EQ(taken(), 2);
  EXPECT_EQ(taken(), 1);
  EXPECT_EQ(taken(), 2);
  EXPECT_EQ(taken(), 0);
  lone.wired.sensor.on_emergency(can::emergency_frame(2, {.code = 0x2310}));
  EXPECT_EQ(taken(), 2) << "although the turn is the amplifier's";
}

TEST_F(Events, NameAnotherControllerOncePerFault) {
  support::LoneAxis lone = axis();
  controller::WiredAxis& wired = lone.wired;
  const controller::ForeignFrame first{.kind = controller::ForeignFrame::Kind::sync, .id = 0x80};
  const controller::ForeignFrame second{.kind = controller::ForeignFrame::Kind::command, .id = 0x201};
  wired.on_another_controller(first, 1.0);
  EXPECT_EQ(wired.axis.state(), controller::AxisState::offline);
  EXPECT_FALSE(wired.take_event()) << "an axis that is offline disturbs nobody";
  wired.axis.start(false);
  wired.on_another_controller(first, 2.0);
  EXPECT_EQ(wired.axis.fault().cause, controller::Cause::another_controller);
  wired.on_another_controller(second, 3.0);
  const auto event = wired.take_event();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->frame, first);
  EXPECT_FALSE(wired.take_event());
}

TEST(StopRequest, StopsEveryAxis) {
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
