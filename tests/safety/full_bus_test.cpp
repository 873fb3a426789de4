// A bus that other nodes fill: the commands wait in the queue of the controller's interface and would all
// reach the amplifier when the bus is free again.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/fault_rig.h"
#include "tests/support/shows.h"

namespace hystcan::support::full_bus_test {
namespace {

using controller::AxisState;
using controller::Cause;
using std::chrono::microseconds;
using std::chrono::milliseconds;

/// Sends frames of the highest priority so that no other frame gets through.
class FullBus {
 public:
  explicit FullBus(FaultRig& rig) : rig_(rig) {}
  void fill_for(can::Duration time) {
    for (can::Duration spent{}; spent < time; spent += microseconds(100)) {
      for (int i = 0; i < 2; ++i) rig_.send({.id = 0x001, .length = 8});
      rig_.run_for(microseconds(100));
    }
  }

 private:
  FaultRig& rig_;
};

class BehindAFullBus : public testing::Test {
 protected:
  BehindAFullBus() {
    rig.start();
    EXPECT_TRUE(rig.tracks());
    rig.run_for(milliseconds(200));
  }
  FaultRig rig{one_axis()};
  FullBus bus{rig};
};

TEST_F(BehindAFullBus, TheAxisFaultsWithinThreeCycles) {
  shows("S-039");
  bus.fill_for(milliseconds(4));
  ASSERT_EQ(rig.axis().state(), AxisState::faulted);
  EXPECT_EQ(rig.axis().fault().cause, Cause::commands_late);
}

TEST_F(BehindAFullBus, AtMostOneOldAndOneSafeCommandAreQueued) {
  shows("S-048");
  struct Heard {
    can::Time time;
    bool enable;
  };
  std::vector<Heard> heard;
  const can::AxisWire& wire = rig.config().axes[0].wire;
  can::Decoder<can::AmpCommand> decode(*can::find_layout<can::AmpCommand>(rig.config().database, wire));
  const auto listener = rig.listen([&](const can::Frame& frame) {
    if (frame.id != decode.id()) return;
    if (const auto command = decode(frame)) heard.push_back({rig.clock().now(), command->enable});
  });
  bus.fill_for(milliseconds(15));
  EXPECT_LE(heard.size(), 1u) << "the one that was on its way";
  heard.clear();
  rig.run_for(milliseconds(10));
  ASSERT_FALSE(heard.empty());
  const auto in_a_burst = [&](bool enable) {
    return std::ranges::count_if(heard, [&](const Heard& command) {
      return command.enable == enable && command.time - heard.front().time < milliseconds(1);
    });
  };
  EXPECT_LE(in_a_burst(true), 1);
  EXPECT_EQ(in_a_burst(false), 1);
  EXPECT_GT(heard.size(), 7u) << "the safe command is sent in every cycle again";
  EXPECT_FALSE(heard.back().enable);
  EXPECT_NEAR(rig.stage().plant.drive(), 0.0, 1e-3);
}

TEST_F(BehindAFullBus, ABusyCycleIsTolerated) {
  for (int i = 0; i < 10; ++i) {
    bus.fill_for(microseconds(900));
    rig.run_for(milliseconds(100));
    ASSERT_EQ(rig.axis().state(), AxisState::tracking) << to_string(rig.axis().fault().cause);
  }
}

TEST_F(BehindAFullBus, TheAxisIsArmedAgainWhenTheBusIsFree) {
  bus.fill_for(milliseconds(10));
  rig.run_for(milliseconds(500));
  ASSERT_EQ(rig.ask(controller::Request::Kind::clear), "");
  ASSERT_EQ(rig.ask(controller::Request::Kind::enable), "");
  EXPECT_TRUE(rig.tracks()) << to_string(rig.axis().fault().cause);
}

}  // namespace
}  // namespace hystcan::support::full_bus_test
