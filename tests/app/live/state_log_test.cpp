// The lines of the log that say what happens to the axes.
#include "app/live/state_log.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace hystcan::app::state_log_test {
namespace {

using controller::AxisState;
using controller::Lack;

/// The shipped two-axis stage; axis 0 is x.
class StateLogOfTwoAxes : public testing::Test {
 protected:
  void add(std::size_t axis, double time_s, AxisState state, Lack lacks = Lack::nothing) {
    controller::CycleRecord record;
    record.time_s = time_s;
    record.axis = axis;
    record.report.state = state;
    record.report.lacks = lacks;
    log.add(record);
  }
  std::vector<std::string> lines;
  StateLog log{config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml"),
               [this](can::BusHealthLog::Level, const std::string& line) { lines.push_back(line); }};
};

TEST_F(StateLogOfTwoAxes, SaysOnceAfterTwoSecondsWhatAnAxisWaitsFor) {
  for (int i = 0; i < 10; ++i) add(0, 0.5 * i, AxisState::waiting, Lack::sensor_heartbeat);
  const std::vector<std::string> expected{"x: waiting for amplifier node 1 and sensor node 2",
                                          "x: still waits for a heartbeat of the sensor"};
  EXPECT_EQ(lines, expected);
}

TEST_F(StateLogOfTwoAxes, SaysNothingOfWhatIsMissingForAMoment) {
  add(0, 0.0, AxisState::waiting, Lack::sensor_heartbeat);
  add(0, 1.9, AxisState::waiting, Lack::sample);
  add(0, 3.8, AxisState::waiting, Lack::amplifier_rest);
  EXPECT_EQ(lines.size(), 1u);
}

TEST_F(StateLogOfTwoAxes, NamesTheAxisWithoutWhichTheOthersBegin) {
  add(1, 0.0, AxisState::waiting, Lack::amplifier_ready);
  add(0, 0.0, AxisState::tracking);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines.back(),
            "y: not ready, waits for an amplifier status that says ready: the other axes begin without it");
}

TEST_F(StateLogOfTwoAxes, KnowsWhetherAnythingWasTracked) {
  add(0, 0.0, AxisState::waiting, Lack::sample);
  add(0, 0.1, AxisState::initialising);
  EXPECT_FALSE(log.has_tracked());
  EXPECT_EQ(log.first_lack(), "x waited for a sample");
  add(0, 0.2, AxisState::tracking);
  EXPECT_TRUE(log.has_tracked());
}

}  // namespace
}  // namespace hystcan::app::state_log_test
