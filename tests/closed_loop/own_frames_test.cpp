// The controller's own frames: the axis status that it sends, and the live setpoints that it receives.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/count_allocations.h"
#include "tests/support/rehearsed.h"

namespace hystcan::own_frames_test {
namespace {

using controller::AxisState;
using controller::Cause;
using std::chrono::milliseconds;

const config::Config& shipped() {
  static const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  return config;
}

rehearsal::Setup setup_of(bool live_setpoint) {
  rehearsal::Setup setup = support::setup_of(shipped());
  for (controller::WiredAxisConfig& axis : setup.controller.axes) axis.live_setpoint = live_setpoint;
  return setup;
}

/// A rehearsal with a foreign node that stores the statuses of both axes and can send frames.
struct ObservedLoop {
  explicit ObservedLoop(const rehearsal::Setup& setup = setup_of(true))
      : rehearsal(setup, [](const controller::CycleRecord&) {}) {
    foreign_node->on_frame([this](const can::Frame& frame, can::Time when) {
      if (frame.id == 0x281 || frame.id == 0x283) statuses.push_back({frame, when});
      if (frame.id == 0x281) last = decode(frame);
    });
    rehearsal.start();
  }
  void track() {
    rehearsal.run_for(std::chrono::seconds(2));
    ASSERT_EQ(axis().state(), AxisState::tracking);
    statuses.clear();
  }
  void send(const can::Frame& frame) {
    foreign_node->send(frame);
    rehearsal.run_for(milliseconds(2));
  }
  const controller::Axis& axis() { return rehearsal.controller().axis(0); }
  controller::SetpointCounters counters() {
    return rehearsal.controller().wired_axis(0).setpoint_receiver->counters();
  }

  struct ReceivedFrame {
    can::Frame frame;
    can::Time when;
  };
  std::vector<ReceivedFrame> statuses;
  can::Decoder<can::ControllerStatus> decode{*shipped().database.find("XControllerStatus")};
  std::optional<can::ControllerStatus> last;
  rehearsal::Rehearsal rehearsal;
  std::unique_ptr<can::Bus> foreign_node = rehearsal.attach()({});
};

// docs/protocol/own_frames.md explains these bytes.
TEST(ControllerStatusFrame, HasTheDocumentedBytes) {
  can::Encoder<can::ControllerStatus> encode(*shipped().database.find("XControllerStatus"));
  std::optional<can::Frame> frame;
  for (int i = 0; i < 4; ++i)  // counters 0, 1, 2, 3
    frame = encode({.following_error_um = -0.25,
                    .state = static_cast<std::uint8_t>(AxisState::tracking),
                    .cause = static_cast<std::uint8_t>(Cause::none),
                    .in_position = true,
                    .limited = true});
  ASSERT_TRUE(frame);
  EXPECT_EQ(*frame,
            (can::Frame{.id = 0x281, .length = 8, .data = {0x70, 0x2F, 0xFC, 0xFF, 0x04, 0x00, 0x33, 0x2E}}));
}

TEST(ControllerStatusFrame, NamesStatesAndCausesInTheDbcAsInTheLog) {
  using Words = std::map<std::int64_t, std::string>;
  Words states;
  for (std::size_t i = 0; i < controller::axis_state_count; ++i)
    states[static_cast<std::int64_t>(i)] = to_string(static_cast<AxisState>(i));
  Words causes;
  for (std::size_t i = 0; i < controller::cause_count; ++i)
    causes[static_cast<std::int64_t>(i)] = to_string(static_cast<Cause>(i));
  for (const auto& [file, name] :
       {std::pair{"hystcan.dbc", "XControllerStatus"}, std::pair{"hystcan.dbc", "YControllerStatus"},
        std::pair{"galfenol.dbc", "XControllerStatus"}}) {
    const can::Database database = can::load_dbc(std::string(HYSTCAN_SOURCE_DIR "/config/") + file);
    const can::Message& message = *database.find(name);
    EXPECT_EQ(message.find("State")->values, states) << name << " in " << file;
    EXPECT_EQ(message.find("Cause")->values, causes)
        << name << " in " << file << ": its VAL_ has every Cause by the same name";
  }
}

TEST(ControllerStatus, IsSentWithEachHeartbeatOfTheController) {
  ObservedLoop loop;
  loop.track();
  loop.rehearsal.run_for(milliseconds(1000));
  EXPECT_EQ(loop.statuses.size(), 20u) << "two axes, ten heartbeats a second";
  ASSERT_TRUE(loop.last);
  EXPECT_EQ(loop.last->state, static_cast<std::uint8_t>(AxisState::tracking));
  EXPECT_EQ(loop.last->cause, static_cast<std::uint8_t>(Cause::none));
  EXPECT_NE(loop.last->following_error_um, 0.0);
  EXPECT_LT(std::abs(loop.last->following_error_um), 0.5) << "um; the stage follows";
  for (const auto& [frame, when] : loop.statuses) EXPECT_EQ(frame.length, 8);
}

TEST(ControllerStatus, ReportsEveryStateOfTheStart) {
  rehearsal::Setup setup = setup_of(false);
  setup.controller.axes.resize(1);  // with several axes, a state may end before the slot of the axis
  ObservedLoop loop(setup);
  std::vector<std::uint8_t> states;
  const auto listener = loop.rehearsal.attach()({});
  listener->on_frame([&](const can::Frame& frame, can::Time) {
    if (frame.id == 0x281 && (states.empty() || states.back() != frame.data[4]))
      states.push_back(frame.data[4]);
  });
  loop.rehearsal.run_for(std::chrono::seconds(2));
  EXPECT_EQ(states, (std::vector<std::uint8_t>{1, 2, 3, 4})) << "waiting, initialising, ready, tracking";
}

TEST(ControllerStatus, ReportsAFaultInTheCycleThatFindsIt) {
  ObservedLoop loop;
  loop.track();
  loop.rehearsal.run_for(milliseconds(50));  // between two heartbeats
  loop.statuses.clear();
  const can::Time before = loop.rehearsal.clock().now();
  loop.foreign_node->send(can::heartbeat_frame(1, can::NmtState::boot_up));
  loop.rehearsal.run_for(milliseconds(5));
  const auto reported =
      std::ranges::find(loop.statuses, 0x281u, [](const auto& received) { return received.frame.id; });
  ASSERT_NE(reported, loop.statuses.end());
  EXPECT_EQ(reported->frame.data[4], static_cast<std::uint8_t>(AxisState::faulted));
  EXPECT_EQ(reported->frame.data[5], static_cast<std::uint8_t>(Cause::node_restarted));
  EXPECT_LT(reported->when - before, milliseconds(2))
      << "the controller acts on the boot-up in the next cycle";
}

TEST(ControllerStatus, IsNotSentIfTheDatabaseHasNoSuchMessage) {
  rehearsal::Setup setup = setup_of(false);
  std::erase_if(setup.database.messages, [](const can::Message& message) {
    return message.name.ends_with("ControllerStatus") || message.name == "XSetpoint" ||
           message.name == "YSetpoint";
  });
  ObservedLoop loop(setup);
  loop.rehearsal.run_for(std::chrono::seconds(2));
  EXPECT_EQ(loop.axis().state(), AxisState::tracking);
  EXPECT_TRUE(loop.statuses.empty());
}

can::Frame setpoint(std::array<std::uint8_t, 8> bytes) {
  can::Frame frame{.id = 0x301, .length = 8};
  std::ranges::copy(bytes, frame.data.begin());
  return frame;
}

// Literal bytes, as a user with a CAN adapter sends them.
constexpr std::array<std::uint8_t, 8> go_to_12500_nm{0x20, 0xBC, 0xBE, 0x00, 0x01, 0x00, 0x00, 0x91};
constexpr std::array<std::uint8_t, 8> follow_again{0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0xE5};
constexpr std::array<std::uint8_t, 8> go_to_40_um{0x00, 0x5A, 0x62, 0x02, 0x01, 0x00, 0x02, 0x22};
constexpr std::array<std::uint8_t, 8> mode_7{0x40, 0x81, 0xBA, 0x01, 0x07, 0x00, 0x03, 0x5F};

TEST(LiveSetpoint, IsFollowedWhileTrackingUntilTheReferenceIsResumed) {
  ObservedLoop loop;
  loop.track();
  loop.send(setpoint(go_to_12500_nm));
  loop.rehearsal.run_for(milliseconds(3));
  EXPECT_TRUE(loop.axis().report().point.live);
  EXPECT_EQ(loop.counters().taken, 1u);
  EXPECT_FALSE(loop.rehearsal.controller().axis(1).report().point.live) << "the frame is not for y";
  loop.rehearsal.run_for(milliseconds(1500));
  EXPECT_EQ(loop.axis().report().reference_um, 12.5);
  EXPECT_NEAR(loop.axis().report().position_um, 12.5, 0.01);
  loop.send(setpoint(follow_again));
  loop.rehearsal.run_for(milliseconds(3));
  EXPECT_FALSE(loop.axis().report().point.live);
  EXPECT_EQ(loop.counters().taken, 2u);
  EXPECT_EQ(loop.counters().refused(), 0u);
}

TEST(LiveSetpoint, IsRefusedAndCountedWhenItCannotBeFollowed) {
  ObservedLoop loop;
  loop.rehearsal.run_for(milliseconds(500));  // initialising
  loop.send(setpoint(go_to_12500_nm));
  EXPECT_EQ(loop.counters().not_tracking, 1u);
  loop.track();
  loop.send(setpoint(go_to_40_um));
  EXPECT_EQ(loop.counters().out_of_range, 1u);
  loop.send(setpoint(mode_7));
  EXPECT_EQ(loop.counters().unknown_mode, 1u);
  EXPECT_EQ(loop.counters().taken, 0u);
  loop.rehearsal.run_for(milliseconds(3));
  EXPECT_FALSE(loop.axis().report().point.live);
  EXPECT_EQ(describe(loop.counters()),
            "0 live setpoints accepted, refused: 1 not tracking, 1 out of range, 1 unknown mode");
}

TEST(LiveSetpoint, IsRejectedWithItsCauseWhenDamagedOrRepeated) {
  ObservedLoop loop;
  loop.track();
  can::Frame damaged = setpoint(go_to_12500_nm);
  damaged.data[0] ^= 1;
  loop.send(damaged);
  can::Frame cut = setpoint(go_to_12500_nm);
  cut.length = 7;
  loop.send(cut);
  loop.rehearsal.run_for(milliseconds(3));
  EXPECT_FALSE(loop.axis().report().point.live);
  loop.send(setpoint(go_to_12500_nm));
  loop.send(setpoint(go_to_12500_nm));  // the same counter
  std::string description;
  for (const can::RejectedFrames& rejected : loop.rehearsal.controller().rejected())
    if (rejected.message == "XSetpoint") description = describe(rejected);
  EXPECT_EQ(description, "XSetpoint: rejected: 1 wrong length, 1 wrong CRC, 1 repeated counter");
  EXPECT_EQ(loop.counters().taken, 1u);
}

TEST(LiveSetpoint, IsIgnoredIfNotConfigured) {
  ObservedLoop loop(setup_of(false));
  loop.track();
  loop.send(setpoint(go_to_12500_nm));
  loop.rehearsal.run_for(milliseconds(3));
  EXPECT_FALSE(loop.axis().report().point.live);
  EXPECT_FALSE(loop.rehearsal.controller().wired_axis(0).setpoint_receiver);
}

TEST(ControllerFrames, AllocateNothing) {
  ObservedLoop loop;
  loop.track();
  loop.statuses.reserve(1000);
  can::Encoder<can::Setpoint> encode(*shipped().database.find("XSetpoint"));
  const std::uint64_t before = support::allocations_so_far();
  for (int i = 0; i < 100; ++i)
    loop.send(*encode({.position_um = 10.0, .mode = static_cast<std::uint8_t>(i % 2)}));
  EXPECT_EQ(support::allocations_so_far(), before);
  EXPECT_EQ(loop.counters().taken, 100u);
  EXPECT_GT(loop.statuses.size(), 3u);
}

}  // namespace
}  // namespace hystcan::own_frames_test
