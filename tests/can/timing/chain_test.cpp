// The bound of the chain on sets that are small enough for a manual count. At 1 Mbit/s a bit takes 1 us; a
// frame of 8 bytes has 135 bits and a frame of 1 byte has 65 bits.
#include "can/timing/chain.h"
#include "can/timing/schedulability.h"

#include <gtest/gtest.h>

#include <vector>

namespace hystcan::can::chain_test {
namespace {

using namespace std::chrono_literals;

constexpr ChainTiming timing{.rates = {}, .cycle = 2ms, .turnaround = 0ms};

ChainSource source(ChainRole role, std::uint32_t id, unsigned bytes, Duration period) {
  ChainSource made;
  made.frame = {.name = std::to_string(id), .id = id, .bytes = bytes, .period = period, .deadline = period};
  made.role = role;
  if (role == ChainRole::sample || role == ChainRole::command) made.axes = {0};
  return made;
}

std::vector<ChainSource> chain(std::uint32_t sample, std::uint32_t command) {
  return {source(ChainRole::sync, 0x080, 1, timing.cycle), source(ChainRole::sample, sample, 8, timing.cycle),
          source(ChainRole::command, command, 8, timing.cycle)};
}

void add_others(std::vector<ChainSource>& sources, std::uint32_t first, int count) {
  for (int i = 0; i < count; ++i)
    sources.push_back(source(ChainRole::heartbeat, first + static_cast<std::uint32_t>(i), 8, 100ms));
}

TEST(Chain, LastsForItsFramesAndTheTurnaroundIfItIsAlone) {
  const auto sources = chain(0x181, 0x201);
  ChainTiming slow = timing;
  slow.turnaround = 70us;
  EXPECT_EQ(chain_response(sources, sources[0], slow), 65us);
  EXPECT_EQ(chain_response(sources, sources[1], slow), 65us + 70us + 135us);
  EXPECT_EQ(chain_response(sources, sources[2], slow), 65us + 70us + 135us + 135us);
}

TEST(Chain, WaitsOnceAtEachLinkForAFrameOfLowerPriority) {
  auto sources = chain(0x181, 0x201);
  add_others(sources, 0x300, 6);
  EXPECT_EQ(chain_response(sources, sources[0], timing), 65us + 135us);
  EXPECT_EQ(chain_response(sources, sources[1], timing), 200us + 2 * 135us);
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 3 * 135us);
}

TEST(Chain, WaitsForAllFramesOfHigherPriorityThanItsWeakestLink) {
  for (const auto& [sample, command] : {std::pair{0x400U, 0x100U}, std::pair{0x100U, 0x400U}}) {
    auto sources = chain(sample, command);
    add_others(sources, 0x200, 6);
    EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 6 * 135us);
  }
  auto sources = chain(0x010, 0x020);
  add_others(sources, 0x030, 6);
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 6 * 135us) << "SYNC is the weakest link";
}

TEST(Chain, CountsAllCommandsAsTheWeakestCommand) {
  auto sources = chain(0x181, 0x201);
  sources.push_back(source(ChainRole::command, 0x401, 8, timing.cycle));
  sources.back().axes = {1};
  add_others(sources, 0x300, 6);
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 135us + 6 * 135us)
      << "the other command may be first in the controller's queue and wait for all six";
}

TEST(Chain, WithASharedCommandIncludesTheLatestSample) {
  auto sources = chain(0x181, 0x201);
  sources.push_back(source(ChainRole::sample, 0x400, 8, timing.cycle));
  sources.back().axes = {1};
  sources[2].axes = {0, 1};
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 135us) << "the other sample passes before";
  add_others(sources, 0x300, 6);
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 135us + 6 * 135us)
      << "the weaker sample may come last, and waits for all six";
}

TEST(Chain, WithASharedSampleIncludesEachCommand) {
  auto sources = chain(0x181, 0x201);
  sources.push_back(source(ChainRole::command, 0x202, 8, timing.cycle));
  sources.back().axes = {1};
  sources[1].axes = {0, 1};
  EXPECT_EQ(chain_response(sources, sources[1], timing), 200us) << "both commands come after the sample";
  EXPECT_EQ(chain_response(sources, sources[3], timing), 335us + 135us);
}

TEST(Chain, DoesNotWaitForHeartbeatsQueuedAfterTheCommands) {
  auto sources = chain(0x181, 0x201);
  sources.push_back(source(ChainRole::controller_heartbeat, 0x77F, 1, 100ms));
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us);
}

/// A chain and heartbeats of 8 bytes in these slots of eight.
std::vector<ChainSource> chain_with_slots(const std::vector<unsigned>& slots) {
  auto sources = chain(0x181, 0x201);
  add_others(sources, 0x701, static_cast<int>(slots.size()));
  for (std::size_t i = 0; i < slots.size(); ++i) sources[3 + i].slot = slots[i];
  return sources;
}

TEST(Chain, IncludesTheFrameOfASlotOnceAfterSync) {
  const auto sources = chain_with_slots({0, 3, 6});
  ChainTiming slots = timing;
  slots.slots = 8;
  EXPECT_EQ(chain_response(sources, sources[0], slots), 65us);
  EXPECT_EQ(chain_response(sources, sources[1], slots), 200us + 135us);
  EXPECT_EQ(chain_response(sources, sources[2], slots), 335us + 135us);
}

// A cycle has 335 us of links and 135 us of a slot. With 380 us, 90 us remain, and 45 us after the next one
// without a slot.
TEST(Chain, IncludesSuccessiveSlotsThatOverrunTheCycle) {
  ChainTiming quick = timing;
  quick.cycle = 380us;
  quick.slots = 8;
  const auto response = [&](const std::vector<unsigned>& of, std::size_t link) {
    const auto sources = chain_with_slots(of);
    return chain_response(sources, sources[link], quick);
  };
  EXPECT_EQ(response({0, 4}, 2), 335us + 135us);
  EXPECT_EQ(response({0, 4}, 0), 90us + 65us);
  EXPECT_EQ(response({0, 1}, 2), 335us + 135us + 90us);
  EXPECT_EQ(response({0, 2}, 2), 335us + 135us + 45us);
  EXPECT_EQ(response({7, 0}, 2), 335us + 135us + 90us) << "a round follows the other";
}

TEST(Chain, WaitsForAllFramesThatPassTheControllersFrameInItsQueue) {
  auto sources = chain_with_slots({0});
  sources.back().role = ChainRole::controller_heartbeat;
  ChainTiming slots = timing;
  slots.slots = 8;
  add_others(sources, 0x300, 6);
  EXPECT_EQ(chain_response(sources, sources[2], slots), 335us + 135us + 6 * 135us);
}

TEST(Chain, WaitsTwiceForAFrameThatMayBeLeftOver) {
  auto sources = chain(0x181, 0x201);
  sources.push_back(source(ChainRole::status, 0x190, 8, timing.cycle));
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 135us);
  sources.back().response = 1700us;
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 2 * 135us);
}

TEST(Chain, WaitsForTheCycleBeforeIfAHeartbeatMayBeLeftInTheQueue) {
  auto sources = chain(0x181, 0x201);
  add_others(sources, 0x700, 14);
  // 335 us and 14 frames are 2225 us: the second SYNC may wait, and none of these frames recurs by then.
  EXPECT_EQ(chain_response(sources, sources[0], timing), 2225us + 65us - 2000us);
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 3 * 135us)
      << "three blocking frames take more than the frames that are left over";
}

TEST(Chain, HasNoBoundIfTheBusIsFull) {
  auto sources = chain(0x181, 0x201);
  for (std::uint32_t id = 0x700; id < 0x70D; ++id)
    sources.push_back(source(ChainRole::heartbeat, id, 8, timing.cycle));
  respond(sources, timing);  // 335 us and 13 frames of 135 us in each 2000 us
  EXPECT_FALSE(sources[2].response);
}

}  // namespace
}  // namespace hystcan::can::chain_test
