// A raster scan over two axes in virtual time: the axes stay in phase, even after faults.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"

namespace hystcan::raster_test {
namespace {

using controller::AxisState;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Kind = controller::Request::Kind;

/// The shipped scan, repeated.
class Scan : public testing::Test {
 protected:
  void begin(const std::vector<config::Setting>& settings = {}) {
    loop_ = std::make_unique<rehearsal::Rehearsal>(
        support::shipped("raster.toml", settings),
        [this](const auto& record) { latest_.at(record.axis) = record; });
    loop_->controller().listen_to(requests_);
    loop_->start();
  }
  const controller::Axis& axis(std::size_t i) { return std::as_const(loop_->controller()).axis(i); }
  bool reaches(std::size_t i, AxisState state, can::Duration limit) {
    for (can::Duration spent{}; spent < limit && axis(i).state() != state; spent += milliseconds(1))
      loop_->run_for(milliseconds(1));
    return axis(i).state() == state;
  }
  void ask(Kind kind, std::size_t i) {
    auto request = std::make_unique<controller::Request>();
    request->kind = kind;
    request->axis = i;
    ASSERT_TRUE(requests_.ask(std::move(request)));
    loop_->run_for(milliseconds(2));
    EXPECT_EQ(requests_.take_answer()->refusal, std::nullopt);
  }
  /// Makes the sensor of axis i silent for a while.
  void silence(std::size_t i) {
    loop_->twin().faults().inject(
        {.kind = twin::Fault::no_reply, .axis = i == 0 ? "x" : "y", .lasts = milliseconds(100)});
    ASSERT_TRUE(reaches(i, AxisState::faulted, milliseconds(50)));
    loop_->run_for(milliseconds(100));
  }
  void arm_again(std::size_t i) {
    ask(Kind::clear, i);
    ask(Kind::enable, i);
  }
  /// Runs for `duration`. Returns the number of cycles in which both axes were on a line, and fails if they
  /// are on different lines.
  int cycles_on_the_same_line(can::Duration duration) {
    int cycles = 0;
    for (can::Duration spent{}; spent < duration; spent += milliseconds(1)) {
      loop_->run_for(milliseconds(1));
      const auto& x = latest_[0].report.point.scan;
      const auto& y = latest_[1].report.point.scan;
      if (latest_[0].cycle != latest_[1].cycle || !x || !y) continue;
      EXPECT_EQ(x->frame, y->frame);
      EXPECT_EQ(x->line, y->line);
      EXPECT_EQ(x->pixel, y->pixel);
      ++cycles;
    }
    return cycles;
  }
  /// Expects that y rests at its level while x is on the straight part of a line.
  void expect_levels() {
    const auto& y = latest_[1].report;
    if (y.point.scan && y.point.scan->pixel >= 0) {
      EXPECT_NEAR(y.reference_um, 5.0 + 20.0 * y.point.scan->line / 31.0, 1e-9);
    }
  }

  controller::RequestLink requests_;
  std::vector<controller::CycleRecord> latest_{2};
  std::unique_ptr<rehearsal::Rehearsal> loop_;
};

TEST_F(Scan, MovesTheSlowAxisOnlyBetweenTheLines) {
  begin();
  ASSERT_TRUE(reaches(0, AxisState::tracking, seconds(5)));
  for (int i = 0; i < 2000; ++i) {
    loop_->run_for(milliseconds(1));
    expect_levels();
  }
}

TEST_F(Scan, HasBothAxesOnTheSameLineFromTheStartOn) {
  begin();
  ASSERT_TRUE(reaches(0, AxisState::tracking, seconds(5)));
  // A pass of 1.9 s has 32 lines of 50 ms.
  EXPECT_NEAR(cycles_on_the_same_line(milliseconds(5700)), 3 * 32 * 50, 10);
}

TEST_F(Scan, HasBothAxesOnTheSameLineAfterOneHasFaultedAndIsArmedAgain) {
  for (const std::size_t faulty : {0U, 1U}) {
    begin();
    ASSERT_TRUE(reaches(0, AxisState::tracking, seconds(5)));
    loop_->run_for(milliseconds(733));
    ASSERT_NO_FATAL_FAILURE(silence(faulty));
    ASSERT_NO_FATAL_FAILURE(arm_again(faulty));
    ASSERT_TRUE(reaches(faulty, AxisState::tracking, seconds(3)));
    EXPECT_EQ(axis(1 - faulty).state(), AxisState::tracking);
    EXPECT_GT(cycles_on_the_same_line(seconds(4)), 2 * 32 * 50 - 100);
    expect_levels();
  }
}

TEST_F(Scan, HasBothAxesOnTheSameLineAfterBothHaveFaulted) {
  begin();
  ASSERT_TRUE(reaches(0, AxisState::tracking, seconds(5)));
  loop_->run_for(milliseconds(733));
  ASSERT_NO_FATAL_FAILURE(silence(0));
  ASSERT_NO_FATAL_FAILURE(silence(1));
  ASSERT_NO_FATAL_FAILURE(arm_again(1));
  loop_->run_for(milliseconds(317));
  ASSERT_NO_FATAL_FAILURE(arm_again(0));
  ASSERT_TRUE(reaches(0, AxisState::tracking, seconds(3)));
  ASSERT_TRUE(reaches(1, AxisState::tracking, seconds(3)));
  EXPECT_GT(cycles_on_the_same_line(seconds(4)), 2 * 32 * 50 - 100);
}

// Each axis begins alone: the first as soon as it is ready, the second in time with the first.
TEST_F(Scan, HasBothAxesOnTheSameLineAfterSeparateStarts) {
  begin({{"controller.start_together", "false"}, {"axis[1].control.wipe_dwell_s", "0.437"}});
  ASSERT_TRUE(reaches(0, AxisState::tracking, seconds(5)));
  EXPECT_EQ(axis(1).state(), AxisState::initialising);
  ASSERT_TRUE(reaches(1, AxisState::tracking, seconds(5)));
  EXPECT_GT(cycles_on_the_same_line(seconds(4)), 2 * 32 * 50 - 100);
}

/// The scan markers of x on the bus, from the start.
TEST_F(Scan, SendsAMarkerAtTheBeginningOfEachLine) {
  begin();
  const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/raster.toml");
  can::Decoder<can::ScanMarker> decode{*config.database.find("XScanMarker")};
  std::vector<can::ScanMarker> markers;
  const std::unique_ptr<can::Bus> observer = loop_->attach()({});
  std::uint8_t sync = 0;
  observer->on_frame([&](const can::Frame& frame, can::Time) {
    if (const auto counter = can::parse_sync(frame)) sync = *counter;
    const auto marker = frame.id == 0x381 ? decode(frame) : std::nullopt;
    if (!marker) return;
    markers.push_back(*marker);
    EXPECT_EQ(marker->sync_counter, sync) << "it comes within the cycle";
  });
  ASSERT_TRUE(reaches(0, AxisState::tracking, seconds(5)));
  loop_->run_for(milliseconds(200 + 1900 + 10));  // the transition and one pass, including the return
  ASSERT_EQ(markers.size(), 33U);
  for (std::size_t i = 0; i < markers.size(); ++i) {
    EXPECT_EQ(markers[i].line, i % 32) << i;
    EXPECT_EQ(markers[i].frame, 0U);
  }
}

// docs/protocol/other_nodes.md explains these bytes.
TEST(ScanMarkerFrame, HasTheDocumentedBytes) {
  const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/raster.toml");
  can::Encoder<can::ScanMarker> encode(*config.database.find("XScanMarker"));
  const auto frame = encode({.line = 300, .frame = 2, .sync_counter = 77});
  ASSERT_TRUE(frame);
  EXPECT_EQ(*frame,
            (can::Frame{.id = 0x381, .length = 8, .data = {0x2C, 0x01, 0x02, 0x00, 0x4D, 0x00, 0x00, 0xAB}}));
}

TEST_F(Scan, SendsNoMarkerFromAFaultedAxis) {
  begin();
  ASSERT_TRUE(reaches(0, AxisState::tracking, seconds(5)));
  loop_->run_for(milliseconds(733));
  ASSERT_NO_FATAL_FAILURE(silence(0));
  int markers = 0;
  const std::unique_ptr<can::Bus> observer = loop_->attach()({});
  observer->on_frame([&](const can::Frame& frame, can::Time) { markers += frame.id == 0x381 ? 1 : 0; });
  loop_->run_for(seconds(1));
  EXPECT_EQ(markers, 0);
}

TEST_F(Scan, IsTrackedWellOnItsLines) {
  const rehearsal::Outcome outcome =
      rehearsal::run_once(support::shipped("raster.toml"), 0.1, support::ignore);
  EXPECT_LT(outcome.axes[0].statistics.total().rms_um(), 0.1);
  EXPECT_LT(outcome.axes[1].statistics.total().rms_um(), 0.1);
}

}  // namespace
}  // namespace hystcan::raster_test
