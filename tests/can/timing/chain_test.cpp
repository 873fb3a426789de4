// The bound of the chain on sets small enough to count by hand: 1 Mbit/s, a bit is a microsecond; 8 bytes are
// 135 bits, 1 byte 65.
#include "can/timing/chain.h"

#include <gtest/gtest.h>

#include <vector>

namespace hystcan::can {
namespace {

using namespace std::chrono_literals;

constexpr ChainTiming timing{.bitrate_bit_per_s = 1'000'000, .cycle = 2ms, .turnaround = 0ms};

ChainSource source(ChainRole role, std::uint32_t id, unsigned bytes, Duration period) {
  ChainSource made;
  made.frame = {.name = std::to_string(id),
                .id = id,
                .extended = false,
                .bytes = bytes,
                .period = period,
                .jitter = {},
                .deadline = period};
  made.role = role;
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

TEST(Chain, AloneTakesItsFramesAndTheTurnaround) {
  const auto sources = chain(0x181, 0x201);
  ChainTiming slow = timing;
  slow.turnaround = 70us;
  EXPECT_EQ(chain_response(sources, sources[0], slow), 65us);
  EXPECT_EQ(chain_response(sources, sources[1], slow), 65us + 70us + 135us);
  EXPECT_EQ(chain_response(sources, sources[2], slow), 65us + 70us + 135us + 135us);
}

TEST(Chain, IsHeldUpOnceAtEachLinkByWhatGoesAfterIt) {
  auto sources = chain(0x181, 0x201);
  add_others(sources, 0x300, 6);
  EXPECT_EQ(chain_response(sources, sources[0], timing), 65us + 135us);
  EXPECT_EQ(chain_response(sources, sources[1], timing), 200us + 2 * 135us);
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 3 * 135us);
}

TEST(Chain, LetsPassWhatGoesBeforeItsWeakestLink) {
  for (const auto& [sample, command] : {std::pair{0x400U, 0x100U}, std::pair{0x100U, 0x400U}}) {
    auto sources = chain(sample, command);
    add_others(sources, 0x200, 6);
    EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 6 * 135us);
  }
  auto sources = chain(0x010, 0x020);
  add_others(sources, 0x030, 6);
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 6 * 135us) << "the weakest is SYNC";
}

TEST(Chain, CountsAllCommandsAsTheWeakestOfThem) {
  auto sources = chain(0x181, 0x201);
  sources.push_back(source(ChainRole::command, 0x401, 8, timing.cycle));
  sources.back().axis = 1;
  add_others(sources, 0x300, 6);
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 135us + 6 * 135us)
      << "the other command may be before it in the controller's queue, and wait for all six";
}

TEST(Chain, MeetsTwiceWhatMayBeLeftOver) {
  auto sources = chain(0x181, 0x201);
  sources.push_back(source(ChainRole::status, 0x190, 8, timing.cycle));
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 135us);
  sources.back().response = 1700us;
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 2 * 135us);
}

TEST(Chain, IsBehindTheCycleBeforeWhereAHeartbeatMayBeLeftInTheQueue) {
  auto sources = chain(0x181, 0x201);
  add_others(sources, 0x700, 14);
  // 335 and 14 frames are 2225: the second SYNC may wait, and no other of them comes by then.
  EXPECT_EQ(chain_response(sources, sources[0], timing), 2225us + 65us - 2000us);
  EXPECT_EQ(chain_response(sources, sources[2], timing), 335us + 3 * 135us)
      << "a lesser trouble than three now";
}

TEST(Chain, HasNoBoundWhereTheBusIsFull) {
  auto sources = chain(0x181, 0x201);
  for (std::uint32_t id = 0x700; id < 0x70D; ++id)
    sources.push_back(source(ChainRole::heartbeat, id, 8, timing.cycle));
  respond(sources, timing);  // 335 and 13 frames of 135 in each 2000
  EXPECT_FALSE(sources[2].response);
}

}  // namespace
}  // namespace hystcan::can
