// Nodes of the twin whose heartbeats and statuses have slots: node 1 is the amplifier, node 2 the sensor.
#include <gtest/gtest.h>

#include <map>
#include <utility>
#include <vector>

#include "tests/support/shows.h"
#include "tests/twin/twin_bench.h"

namespace hystcan::twin::background_slots_test {
namespace {

using std::chrono::milliseconds;

constexpr unsigned slots = 4;
constexpr std::uint32_t status = 0x181, amplifier_heartbeat = 0x701, sensor_heartbeat = 0x702, sample = 0x182;

Config with_slots() {
  Config config = one_axis();
  config.background_slots = slots;
  config.axes[0].axis.status_every = 2;
  return config;
}

class BackgroundSlots : public testing::Test, public TwinBench {
 protected:
  BackgroundSlots() : TwinBench(with_slots()) {
    witness_ = bus_.attach();
    witness_->on_frame([this](const can::Frame& frame, can::Time) {
      if (frame.id != can::sync_id) frames_.emplace_back(counter_ % slots, frame.id);
    });
  }
  /// Sends only SYNCs, one per millisecond.
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  std::map<unsigned, int> slots_of(std::uint32_t id) const {
    std::map<unsigned, int> found;
    for (const auto& [slot, frame] : frames_)
      if (frame == id) ++found[slot];
    return found;
  }

  std::unique_ptr<can::Bus> witness_;
  std::vector<std::pair<unsigned, std::uint32_t>> frames_;  ///< slot, and number of frames in it
};

using Found = std::map<unsigned, int>;

TEST_F(BackgroundSlots, ContainADueHeartbeatOrElseAStatus) {
  shows("S-102");
  start_nodes();
  cycles(8);
  frames_.clear();
  cycles(400);
  EXPECT_EQ(slots_of(amplifier_heartbeat), (Found{{1, 4}}));
  EXPECT_EQ(slots_of(sensor_heartbeat), (Found{{2, 4}}));
  EXPECT_EQ(slots_of(status), (Found{{1, 400 / 4 - 4}}));
  EXPECT_EQ(slots_of(sample), (Found{{0, 100}, {1, 100}, {2, 100}, {3, 100}})) << "each SYNC has its sample";
}

TEST_F(BackgroundSlots, DoNotHoldBackTheStatusOfAChangedState) {
  shows("S-104");
  start_nodes();
  cycles(3);
  ASSERT_EQ(counter_ % slots, 3u);
  frames_.clear();
  sync();
  command(10.0, true);
  run(milliseconds(1));
  EXPECT_EQ(slots_of(status), (Found{{0, 1}})) << "enabled";
}

TEST_F(BackgroundSlots, AreIgnoredWithoutASync) {
  shows("S-103");
  start_nodes();
  cycles(150);
  frames_.clear();
  run(milliseconds(1000));
  const int heartbeats = slots_of(sensor_heartbeat).begin()->second;
  EXPECT_GE(heartbeats, 9) << "the first one may have waited for a slot";
  EXPECT_LE(heartbeats, 10);
}

}  // namespace
}  // namespace hystcan::twin::background_slots_test
