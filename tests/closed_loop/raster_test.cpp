// A raster scan over two axes in virtual time: the axes stay in phase, also after faults.
#include <gtest/gtest.h>

#include <cmath>
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

/// The shipped scan, which repeats.
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
    EXPECT_EQ(requests_.take_answer()->refused_because, "");
  }
  /// Its sensor says nothing for a while.
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
  /// Runs on; returns how many cycles both axes were on a line, and fails where they are on different ones.
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
  /// y is at rest, at its level, while x is on the straight part of a line.
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

// Each begins alone: the first as soon as it is ready, the second on the time of the first.
TEST_F(Scan, HasBothAxesOnTheSameLineWhereTheyDoNotBeginTogether) {
  begin({{"controller.start_together", "false"}, {"axis[1].control.wipe_dwell_s", "0.437"}});
  ASSERT_TRUE(reaches(0, AxisState::tracking, seconds(5)));
  EXPECT_EQ(axis(1).state(), AxisState::initialising);
  ASSERT_TRUE(reaches(1, AxisState::tracking, seconds(5)));
  EXPECT_GT(cycles_on_the_same_line(seconds(4)), 2 * 32 * 50 - 100);
}

TEST_F(Scan, IsTrackedWellOnItsLines) {
  const rehearsal::Outcome outcome =
      rehearsal::run_once(support::shipped("raster.toml"), 0.1, support::ignore);
  EXPECT_LT(outcome.axes[0].statistics.total().rms_um(), 0.1);
  EXPECT_LT(outcome.axes[1].statistics.total().rms_um(), 0.1);
}

}  // namespace
}  // namespace hystcan::raster_test
