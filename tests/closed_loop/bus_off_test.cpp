// The reaction of the controller when its CAN controller goes bus-off or its interface goes down: it disarms
// immediately, waits for every node again, and arms only on request. The whole loop runs in virtual time; the
// test sets the state of the controller's connection.
#include <gtest/gtest.h>

#include <optional>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/hooked_connection.h"
#include "tests/support/shows.h"

namespace hystcan::bus_off_test {
namespace {

using can::BusState;
using controller::AxisState;
using controller::Cause;
using std::chrono::milliseconds;

struct ControllerOffTheBus : testing::Test {
  ControllerOffTheBus() {
    twin.start();
    switch_on(false);
  }

  void switch_on(bool clear_faults) {
    controller.emplace(
        controller_config(config), config.database, clock,
        [this](std::span<const can::Filter>) {
          auto opened = std::make_unique<support::HookedConnection>(bus.attach(), [this](can::Frame& frame) {
            nmt_frames += frame.id == can::nmt_id ? 1 : 0;
            return true;
          });
          connection = opened.get();
          return opened;
        },
        [](const auto&) {});
    controller->start(clear_faults);
  }
  void run_for(can::Duration duration) { clock.run_until(clock.now() + duration); }
  bool tracks() {
    for (int i = 0; i < 6000 && controller->axis(0).state() != AxisState::tracking; ++i)
      run_for(milliseconds(1));
    return all_are(AxisState::tracking);
  }
  bool all_are(AxisState state) const {
    return controller->axis(0).state() == state && controller->axis(1).state() == state;
  }
  bool amplifiers_are_off() const {
    return twin.axes()[0]->amplifier.state() != can::AmpState::enabled &&
           twin.axes()[1]->amplifier.state() != can::AmpState::enabled;
  }

  const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  can::VirtualClock clock;
  can::SimBus bus{clock, {1'000'000}};
  twin::Twin twin{twin_config(config), config.database, clock, [this](auto) { return bus.attach(); }};
  support::HookedConnection* connection = nullptr;
  int nmt_frames = 0;  ///< NMT frames of the controller
  std::optional<controller::Controller> controller;
};

TEST_F(ControllerOffTheBus, FaultsEvenIfTheBusOffIsShorterThanACycle) {
  shows("S-164");
  ASSERT_TRUE(tracks());
  connection->pretend(BusState::bus_off);
  connection->pretend(BusState::active);
  run_for(milliseconds(3));
  EXPECT_TRUE(all_are(AxisState::faulted));
  EXPECT_EQ(controller->axis(0).fault().cause, Cause::bus_off);
  EXPECT_TRUE(amplifiers_are_off()) << "the safe command goes out as soon as the bus carries it";
}

TEST_F(ControllerOffTheBus, KeepsTrackingWhileTheBusIsInWarningOrPassive) {
  shows("S-163");
  ASSERT_TRUE(tracks());
  connection->pretend(BusState::warning);
  connection->pretend(BusState::passive);
  run_for(milliseconds(50));
  EXPECT_TRUE(all_are(AxisState::tracking));
}

TEST_F(ControllerOffTheBus, TracksAgainOnlyAfterARestartThatMayClearFaults) {
  shows("S-170");
  ASSERT_TRUE(tracks());
  connection->pretend(BusState::bus_off);
  run_for(milliseconds(100));
  controller.reset();
  run_for(milliseconds(1));  // the last frame may still be on the wire
  switch_on(false);
  run_for(milliseconds(1000));
  EXPECT_EQ(controller->axis(0).fault().cause, Cause::amplifier_fault)
      << "the amplifier's watchdog has tripped without commands";
  controller.reset();
  run_for(milliseconds(1));  // the last frame may still be on the wire
  switch_on(true);
  EXPECT_TRUE(tracks());
}

TEST_F(ControllerOffTheBus, StartsEachNodeAgainAfterABusOffWhileWaiting) {
  run_for(milliseconds(130));  // the nodes are started, but have not yet sent a heartbeat as operational
  ASSERT_NE(controller->axis(0).state(), AxisState::faulted);
  const int before = nmt_frames;
  ASSERT_EQ(controller->axis(0).state(), AxisState::waiting);
  connection->pretend(BusState::bus_off);
  run_for(milliseconds(50));
  connection->pretend(BusState::active);
  run_for(milliseconds(1));
  EXPECT_EQ(controller->axis(0).state(), AxisState::waiting)
      << "frames from before the bus-off no longer count";
  EXPECT_TRUE(tracks()) << "no axis was armed, so that no fault has to be cleared";
  EXPECT_GT(nmt_frames, before);
}

}  // namespace
}  // namespace hystcan::bus_off_test
