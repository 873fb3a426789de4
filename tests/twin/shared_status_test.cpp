// The status of an amplifier whose axes share a status, or have separate ones.
#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <vector>

#include "tests/support/shows.h"
#include "tests/twin/shared_bench.h"

namespace hystcan::twin::shared_status_test {
namespace {

using can::AmpState;
using shared_node_test::SharedBench;
using shared_node_test::two_axes;
using shared_node_test::x;
using shared_node_test::y;
using std::chrono::milliseconds;

TEST(SharedAmplifier, SendsTwoStatusesIfEachAxisHasItsOwn) {
  Config config = two_axes();
  config.axes[1].wire.frames->status->message = "StatusOfY";
  SharedBench bench(config);
  bench.start_nodes();
  bench.heard_.clear();
  bench.amplifier(y).begin_internal_fault();
  bench.run(milliseconds(1));
  EXPECT_EQ(bench.heard_[0x181], 0) << "x has not changed";
  EXPECT_EQ(bench.heard_[0x281], 1);
  EXPECT_EQ(bench.statuses_[y]->state, AmpState::fault);
}

// 0x181 in a base frame and in an extended one.
TEST(SharedAmplifier, SendsTwoStatusesIfOnlyTheIdentifierKindDiffers) {
  Config config = two_axes();
  config.axes[1].wire.frames->status->message = "StatusOfYExtended";
  SharedBench bench(config);
  bench.start_nodes();
  std::array<int, 2> heard{};
  bench.tester_->on_frame([&](const can::Frame& frame, can::Time) {
    if (frame.id == 0x181) ++heard.at(frame.extended ? y : x);
  });
  bench.amplifier(y).begin_internal_fault();
  bench.run(milliseconds(1));
  EXPECT_EQ(heard[x], 0) << "x has not changed";
  EXPECT_EQ(heard[y], 1);
}

TEST(SharedAmplifier, SendsOneStatusIfBothRelaysCloseTogether) {
  Config config = two_axes();
  for (WiredAxisConfig& axis : config.axes) axis.axis.enable_delay = milliseconds(5);
  SharedBench bench(config);
  bench.start_nodes();
  bench.heard_.clear();
  bench.drive(20.0, 20.0, 7);
  EXPECT_EQ(bench.statuses_[y]->state, AmpState::enabled);
  EXPECT_EQ(bench.heard_[0x181], 1);
}

TEST(SharedAmplifier, SendsAStatusWithoutAFaultSignal) {
  Config config = two_axes();
  config.axes[1].wire.frames->status->message = "StatusOfY";
  config.axes[1].wire.frames->status->signals.erase("fault");
  SharedBench bench(config);
  bench.start_nodes();
  bench.amplifier(y).begin_internal_fault();
  bench.run(milliseconds(1));
  EXPECT_EQ(bench.statuses_[y]->state, AmpState::fault);
}

// 16 bits of 0.01 V cover 327.67 V. A status with a wrong output would be worse than none.
TEST(SharedAmplifier, SendsNoStatusIfAnOutputDoesNotFitItsSignal) {
  for (const std::size_t axis : {x, y}) {
    Config config = two_axes();
    config.axes[axis].axis.plant.amplifier.drive_max = 400.0;
    SharedBench bench(config);
    bench.start_nodes();
    bench.drive(axis == x ? 327.0 : 20.0, axis == y ? 327.0 : 20.0, 20);
    EXPECT_GT(bench.heard_[0x181], 0);
    bench.drive(axis == x ? 330.0 : 20.0, axis == y ? 330.0 : 20.0, 5);
    bench.heard_.clear();
    bench.drive(axis == x ? 330.0 : 20.0, axis == y ? 330.0 : 20.0, 50);
    EXPECT_EQ(bench.heard_[0x181], 0) << "axis " << axis;
  }
}

/// Returns the status of y in this message after an internal fault.
std::optional<can::AmpStatus> status_of_internal_fault(const char* message) {
  Config config = two_axes();
  config.axes[1].wire.frames->status->message = message;
  SharedBench bench(config);
  bench.start_nodes();
  bench.amplifier(y).begin_internal_fault();
  bench.run(milliseconds(1));
  return bench.statuses_[y];
}

TEST(SharedAmplifier, ReportsAFaultUnchangedInASignalOf32Bits) {
  EXPECT_EQ(status_of_internal_fault("StatusOfY")->fault, node::internal_fault);
}

TEST(SharedAmplifier, SendsTheStatusIfItsFaultSignalHoldsOnlyZero) {
  const auto status = status_of_internal_fault("StatusOfYWithoutFault");
  EXPECT_EQ(status->state, AmpState::fault);
  EXPECT_EQ(status->fault, 0);
}

TEST(SharedAmplifier, SendsOnlyTheConfiguredStatuses) {
  Config config = two_axes();
  config.axes[0].wire.frames->status.reset();
  SharedBench bench(config);
  bench.start_nodes();
  bench.heard_.clear();
  bench.amplifier(x).begin_internal_fault();
  bench.run(milliseconds(1));
  EXPECT_EQ(bench.heard_[0x181], 0);
  bench.amplifier(y).begin_internal_fault();
  bench.run(milliseconds(1));
  EXPECT_EQ(bench.heard_[0x181], 1);
  EXPECT_EQ(bench.statuses_[y]->state, AmpState::fault);
}

/// Returns the identifiers of the statuses of each cycle.
std::vector<std::vector<std::uint32_t>> statuses_by_cycle(unsigned background_slots, int cycles) {
  Config config = two_axes();
  config.background_slots = background_slots;
  config.axes[1].wire.frames->status->message = "StatusOfY";
  for (WiredAxisConfig& axis : config.axes) axis.axis.status_every = 2;
  SharedBench bench(config);
  bench.start_nodes();
  std::vector<std::vector<std::uint32_t>> found;
  bench.tester_->on_frame([&](const can::Frame& frame, can::Time) {
    if (!found.empty() && (frame.id == 0x181 || frame.id == 0x281)) found.back().push_back(frame.id);
  });
  for (int i = 0; i < cycles; ++i) {
    found.emplace_back();
    bench.cycle();
  }
  return found;
}

TEST(SharedAmplifier, SendsTheStatusesOfItsAxesWithTheSameSync) {
  const auto found = statuses_by_cycle(0, 20);
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_EQ(found[i],
              i % 2 == 0 ? std::vector<std::uint32_t>{} : (std::vector<std::uint32_t>{0x181, 0x281}))
        << i;
}

TEST(SharedAmplifier, SendsOneStatusPerSlotInTurn) {
  shows("S-102");
  std::vector<std::uint32_t> order;
  for (const auto& one : statuses_by_cycle(4, 200)) {
    EXPECT_LE(one.size(), 1u);
    order.insert(order.end(), one.begin(), one.end());
  }
  EXPECT_GT(order.size(), 40u) << "in 50 slots, but for those of a heartbeat";
  for (std::size_t i = 1; i < order.size(); ++i) EXPECT_NE(order[i], order[i - 1]) << i;
}

}  // namespace
}  // namespace hystcan::twin::shared_status_test
