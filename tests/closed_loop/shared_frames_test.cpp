// Axes that share frames: one sample frame and one command frame contain the data of two or eight axes.
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"
#include "tests/support/shows.h"

namespace hystcan::shared_frames_test {
namespace {

using controller::AxisState;
using controller::Cause;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;
using support::ignore;
using support::shipped;

can::AmpCommand command_in(const rehearsal::Setup& setup, std::size_t axis, const can::Frame& frame) {
  return can::find_layout<can::AmpCommand>(setup.database, setup.controller.axes[axis].wire)->decode(frame);
}

/// fd_stage.toml at a lower rate, with gains for that rate and a notch without effect.
std::vector<config::Setting> at_rate(const char* rate_Hz, const char* cycle_us) {
  std::vector<config::Setting> settings{{"controller.rate_Hz", rate_Hz},
                                        {"controller.command_deadline_us", "0.0"}};
  for (const std::string axis : {"axis[0]", "axis[1]"})
    settings.insert(settings.end(), {{axis + ".control.delays.command_delay_us", cycle_us},
                                     {axis + ".control.kp", "0.0"},
                                     {axis + ".control.ki_per_s", "300.0"},
                                     {axis + ".control.notch.depth", "1.0"}});
  return settings;
}

/// The loop of fd_stage.toml, and the frames on its bus.
class TwoAxesInAFrame : public testing::Test {
 protected:
  struct Heard {
    can::Frame frame;
    can::Time time;
  };

  void run(can::Duration time) {
    if (!rehearsal) {
      rehearsal.emplace(setup, ignore);
      listener = rehearsal->attach()({});
      listener->on_frame([this](const can::Frame& frame, can::Time at) { heard.push_back({frame, at}); });
      rehearsal->start();
    }
    rehearsal->run_for(time);
  }
  /// Makes the sensor of this axis silent, two seconds after the start.
  void silence_sensor(const char* name, can::Duration lasts) {
    twin::FaultSpec silent = twin::fault_spec(twin::Fault::no_reply, name);
    silent.node = twin::Node::sensor;
    silent.begins = seconds(2);
    silent.lasts = lasts;
    setup.twin.faults = {silent};
  }
  const controller::Axis& axis(std::size_t i) { return rehearsal->controller().axis(i); }
  bool both_track() {
    return axis(0).state() == AxisState::tracking && axis(1).state() == AxisState::tracking;
  }
  std::vector<Heard> with(std::uint32_t id) const {
    std::vector<Heard> found;
    for (const Heard& one : heard)
      if (one.frame.id == id) found.push_back(one);
    return found;
  }
  static constexpr std::uint32_t sample_id = 0x188, command_id = 0x210;

  rehearsal::Setup setup = shipped("fd_stage.toml");
  std::optional<rehearsal::Rehearsal> rehearsal;
  std::unique_ptr<can::Bus> listener;
  std::vector<Heard> heard;
};

TEST_F(TwoAxesInAFrame, TrackWithOneSampleAndOneCommandInACycle) {
  run(seconds(2));
  ASSERT_TRUE(both_track()) << to_string(axis(0).fault().cause) << ", " << to_string(axis(1).fault().cause);
  heard.clear();
  run(seconds(1));
  EXPECT_NEAR(static_cast<double>(with(sample_id).size()), setup.controller.rate_Hz, 1.0);
  EXPECT_NEAR(static_cast<double>(with(command_id).size()), setup.controller.rate_Hz, 1.0);
  EXPECT_EQ(rehearsal->controller().counters().missing_samples, 0u);
  EXPECT_EQ(rehearsal->controller().counters().late_samples, 0u);
  EXPECT_EQ(rehearsal->controller().counters().replaced_commands, 0u);
}

TEST_F(TwoAxesInAFrame, HaveHeartbeatsAndStatusesInTheSlotsOfTheirNodesAlone) {
  const std::map<std::uint32_t, unsigned> node_of{{0x708, 8}, {0x710, 16}, {0x190, 16}, {0x718, 24}};
  run(seconds(2));
  ASSERT_TRUE(both_track());
  heard.clear();
  run(seconds(1));
  unsigned counter = 0;
  std::map<std::uint32_t, int> in_slot;
  std::map<std::uint32_t, int> elsewhere;
  std::vector<std::uint32_t> of_cycle;
  for (const Heard& one : heard) {
    if (const auto sync = can::parse_sync(one.frame)) {
      EXPECT_LE(of_cycle.size(), 1u);
      of_cycle.clear();
      counter = *sync;
    } else if (const auto node = node_of.find(one.frame.id); node != node_of.end() && counter != 0) {
      of_cycle.push_back(one.frame.id);
      ++(counter % 24 == node->second % 24 ? in_slot : elsewhere)[one.frame.id];
    }
  }
  EXPECT_TRUE(elsewhere.empty()) << std::hex << elsewhere.begin()->first;
  for (const std::uint32_t heartbeat : {0x708U, 0x710U, 0x718U}) EXPECT_NEAR(in_slot[heartbeat], 10, 1);
  EXPECT_NEAR(in_slot[0x190], 4000 / 24 - 10, 2) << "where the node has no heartbeat";
}

TEST_F(TwoAxesInAFrame, DisableAFaultedAxisAndDriveTheOther) {
  run(seconds(2));
  ASSERT_TRUE(both_track());
  rehearsal->controller().axis(1).trip(Cause::following_error, 2.0);
  run(milliseconds(500));
  EXPECT_EQ(axis(0).state(), AxisState::tracking) << to_string(axis(0).fault().cause);
  EXPECT_EQ(axis(1).state(), AxisState::faulted);
  const can::Frame last = with(command_id).back().frame;
  EXPECT_TRUE(command_in(setup, 0, last).enable);
  EXPECT_FALSE(command_in(setup, 1, last).enable);
  EXPECT_NEAR(command_in(setup, 1, last).setpoint, 0.0, 1e-3);
}

TEST_F(TwoAxesInAFrame, BridgeAsManyLostSamplesAsASingleAxis) {
  shows("S-092");
  silence_sensor("x", microseconds(750));  // three samples
  run(seconds(3));
  EXPECT_TRUE(both_track()) << to_string(axis(0).fault().cause) << ", " << to_string(axis(1).fault().cause);
  EXPECT_EQ(rehearsal->controller().counters().missing_samples, 6u);
  EXPECT_EQ(rehearsal->controller().counters().late_samples, 0u);
}

TEST_F(TwoAxesInAFrame, HaveTheSafeDriveOfAnUncontrolledAxis) {
  controller::WiredAxisConfig& y = setup.controller.axes[1];
  setup.controller.resting = {{y.wire, 12.5}};
  setup.controller.axes.resize(1);
  run(seconds(2));
  EXPECT_EQ(axis(0).state(), AxisState::tracking) << to_string(axis(0).fault().cause);
  const can::Frame last = with(command_id).back().frame;
  EXPECT_TRUE(command_in(setup, 0, last).enable);
  const auto layout = can::find_layout<can::AmpCommand>(setup.database, setup.twin.axes[1].wire);
  const can::AmpCommand other = layout->decode(last);
  EXPECT_NEAR(other.setpoint, 12.5, 1e-3);
  EXPECT_FALSE(other.enable);
}

TEST_F(TwoAxesInAFrame, CountARejectedSampleFrameOnce) {
  run(seconds(1));
  can::Frame damaged = with(sample_id).back().frame;
  damaged.data[0] ^= 1U;
  listener->send(damaged);
  run(milliseconds(10));
  std::vector<std::uint64_t> counts;
  for (const can::RejectedFrames& each : rehearsal->controller().rejected())
    if (each.message == "Samples")
      counts.push_back(each.by_cause[static_cast<std::size_t>(can::Rejection::wrong_crc)]);
  EXPECT_EQ(counts, std::vector<std::uint64_t>{1});
}

/// Each axis has its own sensor here, but they share the command frame.
class TwoSensorsAndOneCommand : public TwoAxesInAFrame {
 protected:
  TwoSensorsAndOneCommand() {
    setup = shipped("fd_stage.toml", at_rate("2500.0", "400.0"));
    // The sample of axis y gets its own identifier and node.
    can::Message other = *setup.database.find("Samples");
    other.name = "OtherSamples";
    other.id = 0x183;
    setup.database.messages.push_back(other);
    for (can::AxisWire* wire : {&setup.controller.axes[1].wire, &setup.twin.axes[1].wire}) {
      wire->frames->sample.message = other.name;
      wire->sensor_node = 3;
    }
  }
};

TEST_F(TwoSensorsAndOneCommand, TrackWithOneCommandInACycle) {
  run(seconds(2));
  ASSERT_TRUE(both_track()) << to_string(axis(0).fault().cause) << ", " << to_string(axis(1).fault().cause);
  heard.clear();
  run(seconds(1));
  EXPECT_NEAR(static_cast<double>(with(command_id).size()), setup.controller.rate_Hz, 1.0);
}

TEST_F(TwoSensorsAndOneCommand, DoNotBlockEachOtherIfOneSensorIsSilent) {
  silence_sensor("y", seconds(2));
  run(seconds(3));
  EXPECT_EQ(axis(0).state(), AxisState::tracking) << to_string(axis(0).fault().cause);
  EXPECT_EQ(axis(1).state(), AxisState::faulted);
  heard.clear();
  run(milliseconds(500));
  can::Time sync{};
  can::Duration latest{};
  for (const Heard& one : heard) {
    if (one.frame.id == can::sync_id) sync = one.time;
    if (one.frame.id == command_id && sync != can::Time{}) latest = std::max(latest, one.time - sync);
  }
  EXPECT_LT(latest, can::Duration(microseconds(300))) << "before the deadline, nine tenths of the cycle";
}

TEST_F(TwoSensorsAndOneCommand, SendTheirCommandAtTheDeadlineIfASampleIsLost) {
  silence_sensor("y", microseconds(450));  // one sample
  setup.controller.command_deadline = microseconds(340);
  run(seconds(2));
  heard.clear();
  run(milliseconds(100));
  ASSERT_TRUE(both_track()) << to_string(axis(1).fault().cause);
  EXPECT_EQ(with(command_id).size(), with(can::sync_id).size());
  can::Time sync{};
  std::size_t late = 0;
  for (const Heard& one : heard) {
    if (one.frame.id == can::sync_id) sync = one.time;
    if (one.frame.id == command_id && one.time - sync > microseconds(300)) ++late;
  }
  EXPECT_EQ(late, 1u);
  EXPECT_EQ(rehearsal->controller().counters().missing_samples, 1u);
}

struct FullRate {
  const char* file;
  int seconds;
};

class AxesThatShareFrames : public testing::TestWithParam<FullRate> {};

TEST_P(AxesThatShareFrames, MissNoCycleAndNoSampleAtTheirFullRate) {
  const rehearsal::Setup setup = shipped(GetParam().file);
  rehearsal::Rehearsal rehearsal(setup, ignore);
  controller::Controller& controller = rehearsal.controller();
  rehearsal.start();
  rehearsal.run_for(seconds(2));
  const std::uint64_t before = controller.counters().cycles;
  rehearsal.run_for(seconds(GetParam().seconds));
  for (std::size_t i = 0; i < controller.axis_count(); ++i)
    EXPECT_EQ(controller.axis(i).state(), AxisState::tracking) << to_string(controller.axis(i).fault().cause);
  EXPECT_NEAR(static_cast<double>(controller.counters().cycles - before),
              GetParam().seconds * setup.controller.rate_Hz, 1.0);
  EXPECT_EQ(controller.counters().missed_cycles, 0u);
  EXPECT_EQ(controller.counters().missing_samples, 0u);
  EXPECT_EQ(controller.counters().late_samples, 0u);
  EXPECT_EQ(controller.counters().replaced_commands, 0u);
}

INSTANTIATE_TEST_SUITE_P(, AxesThatShareFrames,
                         testing::Values(FullRate{"fd_stage.toml", 60}, FullRate{"fd_eight.toml", 10}),
                         [](const auto& test) {
                           const std::string file = test.param.file;
                           return file.substr(0, file.find('.'));
                         });

/// Returns the true error of the 50 Hz triangle of axis x, with a controller that compensates the mode of the
/// stage.
double true_rms_um(const std::vector<config::Setting>& settings) {
  return rehearsal::run_once(shipped("fd_stage.toml", settings), 0.1, ignore)
      .true_errors[0]
      .segments()[0]
      .rms_um();
}

// docs/protocol/own_frames.md, "Several axes in a frame".
TEST(TriangleOf50Hz, HasAThirdOfTheTrueErrorAt4000HzComparedWith1000Hz) {
  const double slow_um = true_rms_um(at_rate("1000.0", "1000.0"));
  const double fast_um = true_rms_um({});
  EXPECT_NEAR(slow_um, 0.22, 0.01);
  EXPECT_NEAR(fast_um, 0.072, 0.005);
}

TEST(TriangleOf50Hz, IsLearntWithin3HundredthsOfAPercentOfTheStroke) {
  const auto outcome = rehearsal::run_once(shipped("fd_stage_learning.toml"), 0.1, ignore);
  for (const controller::AxisOutcome& axis : outcome.axes) {
    ASSERT_TRUE(axis.learning);
    EXPECT_LT(axis.learning->rms_um, 0.0003 * axis.stroke_um) << axis.name << ", the last period";
  }
  EXPECT_LT(outcome.true_errors[0].total().rms_um(), 0.0015 * outcome.axes[0].stroke_um)
      << "all periods, and the ringing at the corners that learning leaves to the feed-forward";
}

}  // namespace
}  // namespace hystcan::shared_frames_test
