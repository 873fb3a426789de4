// The CANopen part of the controller: set-up by SDO before the start, emergencies in the cycle record, and a
// heartbeat that stops when the loop stops.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <set>
#include <span>
#include <vector>

#include "config/schema/config.h"
#include "controller/wired_axis.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/hooked_connection.h"
#include "tests/support/lone_axis.h"
#include "tests/support/rehearsed.h"
#include "tests/support/shows.h"

namespace hystcan::node_protocol_test {
namespace {

using controller::AxisState;
using controller::Cause;
using std::chrono::milliseconds;

constexpr can::SdoObject current_limit{.index = 0x2001, .subindex = 1};

rehearsal::Setup one_axis() {
  rehearsal::Setup setup = support::shipped("piezo.toml");
  setup.controller.axes.resize(1);
  setup.twin.axes.resize(1);
  return setup;
}

/// A rehearsal that stores all frames and events.
class LoggedLoop {
 public:
  explicit LoggedLoop(const rehearsal::Setup& setup)
      : rehearsal(setup, [this](const controller::CycleRecord& record) {
          if (record.event) events.push_back(describe(*record.event));
        }) {
    tester->on_frame([this](const can::Frame& frame, can::Time) { frames.push_back(frame); });
    rehearsal.start();
  }
  const controller::Axis& axis() { return rehearsal.controller().axis(0); }
  std::ptrdiff_t first(std::uint32_t id, std::uint8_t byte, std::size_t place) const {
    return std::ranges::find_if(
               frames, [&](const can::Frame& frame) { return frame.id == id && frame.data[place] == byte; }) -
           frames.begin();
  }

  std::vector<std::string> events;
  std::vector<can::Frame> frames;
  rehearsal::Rehearsal rehearsal;
  std::unique_ptr<can::Bus> tester = rehearsal.attach()({});
};

TEST(NodeSetUp, IsWrittenAndReadBackBeforeTheNodeIsStarted) {
  shows("S-150");
  rehearsal::Setup setup = one_axis();
  setup.controller.axes[0].wire.amplifier_setup = {
      {.object = current_limit, .content = {.value = 140, .bytes = 2}},
      {.object = {.index = 0x2002, .subindex = 0}, .content = {.value = 1, .bytes = 1}}};
  LoggedLoop loop(setup);
  loop.rehearsal.run_for(std::chrono::seconds(2));
  EXPECT_EQ(loop.axis().state(), AxisState::tracking);
  EXPECT_EQ(loop.rehearsal.twin().axes()[0]->amplifier.node().objects().object(current_limit)->value, 140u);
  const auto last_read = loop.first(0x581, 0x4F, 0);
  const auto start = loop.first(0x000, 0x01, 1);
  EXPECT_LT(last_read, start) << "node 1 is started after its last object has been read back";
  EXPECT_TRUE(loop.events.empty());
}

TEST(NodeSetUp, IsRepeatedWhenTheNodeRestartsWhileTheAxisWaits) {
  shows("S-110");
  rehearsal::Setup setup = one_axis();
  setup.controller.axes[0].wire.sensor_setup = {
      {.object = current_limit, .content = {.value = 7, .bytes = 1}}};
  LoggedLoop loop(setup);
  loop.rehearsal.run_for(milliseconds(110));
  loop.tester->send(can::nmt_frame({can::NmtCommand::reset_node, 2}));
  loop.rehearsal.run_for(std::chrono::seconds(2));
  EXPECT_EQ(std::ranges::count_if(loop.frames, [](const can::Frame& f) { return f.id == 0x602; }), 4)
      << "a write and a read, each twice";
  EXPECT_EQ(loop.axis().state(), AxisState::tracking);
}

TEST(AmpCommands, BeginWhenTheAmplifierReportsOperational) {
  shows("S-151");
  LoggedLoop loop(one_axis());
  loop.rehearsal.run_for(std::chrono::seconds(1));
  const auto first =
      std::ranges::find_if(loop.frames, [](const can::Frame& frame) { return frame.id == 0x201; });
  ASSERT_NE(first, loop.frames.end());
  EXPECT_LT(loop.first(0x701, 0x05, 0), first - loop.frames.begin());
  EXPECT_LT(loop.first(0x080, 0x01, 0), loop.first(0x701, 0x05, 0)) << "the SYNCs begin before";
  EXPECT_EQ(first->data[4], 0) << "not enabled";
  EXPECT_EQ(first->data[6], 0) << "counter 0";
}

support::LoneAxis lone(const rehearsal::Setup& setup) { return {setup.controller.axes[0], setup.database}; }

TEST(AmplifierStatus, IsClearedWhenTheAmplifierBootsUp) {
  shows("S-101");
  support::LoneAxis axis = lone(one_axis());
  axis.hear_status({.output = 50.0, .state = can::AmpState::enabled});
  ASSERT_TRUE(axis.health().amplifier_enabled);
  axis.wired.amplifier.on_heartbeat(can::heartbeat_frame(1, can::NmtState::boot_up), can::Time{});
  EXPECT_FALSE(axis.health().amplifier_enabled);
  EXPECT_FALSE(axis.health().amplifier_ready);
}

TEST(AmplifierStatus, IgnoresFaultFlagsIfTheStateIsNotFault) {
  shows("S-136");
  support::LoneAxis axis = lone(one_axis());
  axis.hear_status({.state = can::AmpState::ready, .fault = 0x81});
  EXPECT_FALSE(axis.health().amplifier_fault);
  EXPECT_TRUE(axis.health().amplifier_ready);
  axis.hear_status({.state = can::AmpState::fault, .fault = 0});
  EXPECT_TRUE(axis.health().amplifier_fault);
}

TEST(AmplifierWithoutAStatus, IsAssumedReadyEvenAfterABusOff) {
  rehearsal::Setup setup = support::shipped("lab_amplifier.toml");
  setup.controller.axes[0].wire.frames->status.reset();
  support::LoneAxis axis = lone(setup);
  ASSERT_TRUE(axis.health().amplifier_ready);
  axis.wired.amplifier.on_bus_loss(can::BusState::bus_off);
  EXPECT_TRUE(axis.health().amplifier_ready);
}

TEST(Emergencies, AreDescribedAndFaultTheirAxis) {
  shows("S-142");
  LoggedLoop loop(one_axis());
  loop.rehearsal.run_for(std::chrono::seconds(2));
  ASSERT_EQ(loop.axis().state(), AxisState::tracking);
  loop.tester->send(
      can::emergency_frame(1, {.code = 0x2310, .error_register = 0x03, .manufacturer = {0xAB, 0, 0, 0, 1}}));
  loop.tester->send(can::emergency_frame(2, {.code = 0x4200, .error_register = 0x08}));
  loop.tester->send(can::emergency_frame(3, {.code = 0x1000}));
  loop.rehearsal.run_for(milliseconds(5));
  EXPECT_EQ(loop.events,
            (std::vector<std::string>{"node 1: emergency 0x2310: current, device output side (error register "
                                      "0x03, manufacturer AB 00 00 00 01)",
                                      "node 2: emergency 0x4200: device temperature (error register 0x08)"}))
      << "node 3 does not belong to this axis";
  EXPECT_EQ(loop.axis().fault().cause, controller::Cause::node_emergency);
}

TEST(Emergencies, AreIgnoredFromAForeignNodeOrWithoutAnError) {
  shows("S-142");
  LoggedLoop loop(one_axis());
  loop.rehearsal.run_for(std::chrono::seconds(2));
  loop.tester->send(can::emergency_frame(3, {.code = 0x1000}));
  loop.tester->send(can::emergency_frame(2, {.code = 0x0000}));
  loop.rehearsal.run_for(milliseconds(5));
  EXPECT_EQ(loop.axis().state(), AxisState::tracking);
}

TEST(ForeignAccess, IsOnlyCountedIfItReadsOrStarts) {
  shows("S-158");
  LoggedLoop loop(one_axis());
  loop.rehearsal.run_for(std::chrono::seconds(2));
  for (int i = 0; i < 3; ++i)
    loop.tester->send(can::sdo_request(1, {.service = can::SdoService::read, .object = current_limit}));
  loop.tester->send(can::nmt_frame({can::NmtCommand::start, 2}));
  loop.tester->send(can::nmt_frame({static_cast<can::NmtCommand>(119), 2}));
  loop.tester->send(can::nmt_frame({can::NmtCommand::reset_node, 9}));
  loop.rehearsal.run_for(milliseconds(5));
  EXPECT_EQ(loop.axis().state(), AxisState::tracking);
  EXPECT_EQ(loop.events,
            (std::vector<std::string>{
                "node 2: another node sent the NMT command 1 (start) to this node",
                "node 2: another node sent the NMT command 119 (unknown command) to this node"}));
  EXPECT_EQ(loop.rehearsal.controller().node_notes(),
            (std::vector<std::string>{"node 1: 3 SDO reads of another node",
                                      "node 2: 2 NMT commands of another node"}));
}

/// fd_stage.toml: nodes 8 and 16 serve both axes, in rounds of 24 cycles at 4 kHz.
class BackgroundSlots : public testing::Test {
 protected:
  std::vector<std::string> notes() {
    LoggedLoop loop(setup);
    loop.rehearsal.run_for(std::chrono::seconds(3));
    EXPECT_EQ(loop.axis().state(), AxisState::tracking);
    events = loop.events;
    return loop.rehearsal.controller().node_notes();
  }
  std::ptrdiff_t told_of(const std::string& node) const {
    return std::ranges::count_if(events, [&](const std::string& event) {
      return event.starts_with(node + ": heartbeats or statuses of this node arrive outside its slot ");
    });
  }
  rehearsal::Setup setup = support::shipped("fd_stage.toml");
  std::vector<std::string> events;
};

TEST_F(BackgroundSlots, AreNotLoggedIfAllNodesObeyThem) {
  shows("S-106");
  EXPECT_TRUE(notes().empty());
  EXPECT_TRUE(events.empty());
}

TEST_F(BackgroundSlots, AreReportedOncePerNodeThatIgnoresThem) {
  shows("S-106");
  setup.twin.background_slots = 0;
  const std::vector<std::string> lines = notes();
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_TRUE(lines[0].ends_with(" heartbeats and statuses outside the slot of the node")) << lines[0];
  EXPECT_EQ(told_of("node 8"), 2);
  EXPECT_EQ(told_of("node 16"), 2);
  EXPECT_EQ(events.size(), 4U);
}

/// A round lasts 6 ms: a heartbeat waits up to 6 ms.
TEST_F(BackgroundSlots, DelayHeartbeatsWithoutAccumulation) {
  shows("S-105");
  setup.controller.heartbeat_period = milliseconds(13);
  LoggedLoop loop(setup);
  loop.rehearsal.run_for(std::chrono::seconds(2));
  const auto heartbeats =
      std::ranges::count_if(loop.frames, [](const can::Frame& frame) { return frame.id == 0x718; });
  EXPECT_GT(heartbeats, 145) << "2 s / 13 ms = 153, less the start";
}

TEST(ForeignAccess, FaultsTheAxisIfItWrites) {
  shows("S-159");
  LoggedLoop loop(one_axis());
  loop.rehearsal.run_for(std::chrono::seconds(2));
  loop.tester->send(can::sdo_request(2, {.service = can::SdoService::write, .object = current_limit}));
  loop.rehearsal.run_for(milliseconds(2));
  EXPECT_EQ(loop.axis().fault().cause, Cause::foreign_access);
  EXPECT_EQ(loop.events,
            std::vector<std::string>{"node 2: another node wrote to object 0x2001:01 of this node"});
}

/// The fault is decided between two steps. The status of the axis must not delay the safe command.
TEST(ForeignAccess, IsFollowedByTheSafeCommandBeforeTheStatusOfTheAxis) {
  LoggedLoop loop(one_axis());
  loop.rehearsal.run_for(std::chrono::seconds(2));
  loop.frames.clear();
  loop.tester->send(can::nmt_frame({can::NmtCommand::stop, 2}));
  loop.rehearsal.run_for(milliseconds(5));
  constexpr auto faulted = static_cast<std::uint8_t>(AxisState::faulted);
  ASSERT_LT(loop.first(0x281, faulted, 4), std::ssize(loop.frames));
  EXPECT_LT(loop.first(0x201, 0, 4), loop.first(0x281, faulted, 4));
}

TEST(ForeignAccess, RepeatsTheSetUpIfItWritesToAWaitingNode) {
  shows("S-160");
  rehearsal::Setup setup = one_axis();
  setup.controller.axes[0].wire.amplifier_setup = {
      {.object = current_limit, .content = {.value = 7, .bytes = 1}}};
  LoggedLoop loop(setup);
  loop.rehearsal.run_for(milliseconds(130));
  ASSERT_EQ(loop.axis().state(), AxisState::waiting);
  loop.tester->send(can::sdo_request(
      1, {.service = can::SdoService::write, .object = current_limit, .content = {.value = 9, .bytes = 1}}));
  loop.rehearsal.run_for(std::chrono::seconds(2));
  EXPECT_EQ(loop.axis().state(), AxisState::tracking);
  EXPECT_EQ(loop.rehearsal.twin().axes()[0]->amplifier.node().objects().object(current_limit)->value, 7u);
}

/// Some CAN controllers do this if they miss the last bit of an acknowledged frame (ISO 11898-1).
TEST(SampleThatIsSentTwice, IsAcceptedIfIdentical) {
  shows("S-161");
  rehearsal::Setup setup = one_axis();
  LoggedLoop loop(setup);
  loop.tester->on_frame([&](const can::Frame& frame, can::Time) {
    if (frame.id == 0x182) loop.tester->send(frame);
  });
  loop.rehearsal.run_for(std::chrono::seconds(2));
  EXPECT_EQ(loop.axis().state(), AxisState::tracking) << to_string(loop.axis().fault().cause);
}

/// The controller of axis x, whose sensor sends this SyncCounter instead of the right one from `fail` on.
class WrongSyncCounter : public testing::TestWithParam<int> {
 protected:
  WrongSyncCounter() {
    twin_.start();
    controller_.start();
  }
  void run_for(can::Duration duration) { clock_.run_until(clock_.now() + duration); }
  void fail() { fails_ = true; }
  std::string event() const {
    return "node 2: ignored a sample with SyncCounter " + std::to_string(GetParam()) +
           ", expected the counter of the last SYNC, 1 to 240";
  }
  const controller::Axis& axis() const { return controller_.axis(0); }

  can::VirtualClock clock_;
  can::SimBus bus_{clock_, {1'000'000}};
  const rehearsal::Setup setup_ = one_axis();
  bool fails_ = false;
  std::vector<std::string> events_;
  twin::Twin twin_{setup_.twin, setup_.database, clock_, [this](auto) { return bus_.attach(); }};
  controller::Controller controller_{setup_.controller, setup_.database, clock_,
                                     [this](auto) {
                                       return std::make_unique<support::HookedConnection>(
                                           bus_.attach(), support::HookedConnection::Hook{},
                                           [this](can::Frame& frame) {
                                             if (frame.id != 0x182 || !fails_) return true;
                                             frame.data[4] = static_cast<std::uint8_t>(GetParam());
                                             std::array<std::uint8_t, 9> covered{0x82, 0x01};
                                             std::copy_n(frame.data.begin(), 7, covered.begin() + 2);
                                             frame.data[7] = can::crc8_j1850(covered);
                                             return true;
                                           });
                                     },
                                     [this](const controller::CycleRecord& record) {
                                       if (record.event) events_.push_back(describe(*record.event));
                                     }};
};

TEST_P(WrongSyncCounter, FaultsADrivenAxisAsAMissingSample) {
  shows("S-090");
  run_for(std::chrono::seconds(2));
  ASSERT_EQ(axis().state(), AxisState::tracking);
  ASSERT_TRUE(events_.empty());
  fail();
  run_for(milliseconds(20));
  EXPECT_EQ(axis().fault().cause, Cause::sample_missing);
  EXPECT_EQ(controller_.counters().late_samples, 0U);
  ASSERT_FALSE(events_.empty());
  EXPECT_EQ(events_.front(), event());
}

TEST_P(WrongSyncCounter, KeepsAWaitingAxisWaitingForASample) {
  shows("S-090");
  fail();
  run_for(std::chrono::seconds(1));
  EXPECT_EQ(axis().state(), AxisState::waiting);
  EXPECT_EQ(axis().report().arming_blocks, controller::ArmingBlock::sample);
  ASSERT_FALSE(events_.empty());
  EXPECT_EQ(events_.back(), event());
}

INSTANTIATE_TEST_SUITE_P(ThatNoSyncHas, WrongSyncCounter, testing::Values(0, 241, 255));

TEST(RejectedFrames, AreCountedByMessageAndCause) {
  shows("S-078");
  LoggedLoop loop(one_axis());
  loop.rehearsal.run_for(std::chrono::seconds(2));
  ASSERT_EQ(loop.axis().state(), AxisState::tracking);
  loop.tester->send({.id = 0x181, .length = 8});  // no CRC
  loop.tester->send({.id = 0x181, .length = 7});
  loop.tester->send({.id = 0x702, .length = 2, .data = {0x05}});
  loop.tester->send({.id = 0x702, .length = 2, .data = {0x05}});
  loop.tester->send({.id = 0x701, .extended = true, .length = 1, .data = {0x00}});
  loop.tester->send({.id = 0x081, .length = 7, .data = {0x10, 0x23}});
  loop.tester->send({.id = 0x582, .length = 3, .data = {0x60, 0x01, 0x20}});
  loop.tester->send({.id = 0x582, .kind = can::FrameKind::remote, .length = 8});
  loop.rehearsal.run_for(milliseconds(5));
  std::vector<std::string> descriptions;
  for (const can::RejectedFrames& rejected : loop.rehearsal.controller().rejected())
    if (std::string line = describe(rejected); !line.empty()) descriptions.push_back(std::move(line));
  EXPECT_EQ(descriptions, (std::vector<std::string>{"XAmpStatus: rejected: 1 wrong length, 1 wrong CRC",
                                                    "heartbeat of node 1: rejected: 1 wrong identifier type",
                                                    "emergency of node 1: rejected: 1 wrong length",
                                                    "heartbeat of node 2: rejected: 2 wrong length",
                                                    "SDO response of node 2: rejected: 1 not a data frame, "
                                                    "1 wrong length"}))
      << "no sample is rejected";
  EXPECT_TRUE(loop.events.empty()) << "a malformed frame is no emergency";
  EXPECT_EQ(loop.axis().state(), AxisState::tracking);
}

/// The list of all frames that the kernel passes: other frames, however many, do not wake the control thread.
TEST(ControllerFilters, PassFramesOfItsNodesAndOfAnotherController) {
  const rehearsal::Setup setup = one_axis();
  can::VirtualClock clock;
  can::SimBus bus(clock, {1'000'000});
  std::set<std::uint32_t> ids;
  const controller::Controller controller(
      setup.controller, setup.database, clock,
      [&](std::span<const can::Filter> filters) {
        for (const can::Filter& filter : filters) ids.insert(filter.id);
        return bus.attach();
      },
      [](const auto&) {});
  EXPECT_EQ(ids, (std::set<std::uint32_t>{0x000, 0x080, 0x081, 0x082, 0x181, 0x182, 0x201, 0x281, 0x581,
                                          0x582, 0x601, 0x602, 0x701, 0x702, 0x77F}));
}

/// A scheduler whose timers can stop expiring, like a control loop that hangs.
class HangingScheduler final : public can::Scheduler {
 public:
  explicit HangingScheduler(can::Scheduler& inner) : inner_(inner) {}
  can::Time now() const override { return inner_.now(); }
  std::unique_ptr<can::Timer> make_timer(std::function<void()> on_expiry) override {
    return inner_.make_timer([this, on_expiry = std::move(on_expiry)] {
      if (!hangs) on_expiry();
    });
  }
  bool hangs = false;

 private:
  can::Scheduler& inner_;
};

TEST(ControllerHeartbeat, StopsWhenTheControlLoopHangs) {
  shows("S-152");
  const rehearsal::Setup setup = one_axis();
  can::VirtualClock clock;
  can::SimBus bus(clock, {1'000'000});
  const can::Attach attach = [&](auto) { return bus.attach(); };
  HangingScheduler scheduler(clock);
  controller::Controller controller(setup.controller, setup.database, scheduler, attach, [](const auto&) {});
  int heartbeats = 0;
  const auto listener = bus.attach();
  listener->on_frame([&](const can::Frame& frame, can::Time) { heartbeats += frame.id == 0x77F ? 1 : 0; });
  controller.start();
  clock.run_until(clock.now() + milliseconds(1050));  // between two heartbeats, so that none is on the wire
  const int while_running = heartbeats;
  EXPECT_GE(while_running, 9) << "one at start, then every 100 ms";
  scheduler.hangs = true;
  clock.run_until(clock.now() + std::chrono::seconds(1));
  EXPECT_EQ(heartbeats, while_running);
}

}  // namespace
}  // namespace hystcan::node_protocol_test
