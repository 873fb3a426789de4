#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "can/sim/sim_bus.h"
#include "can/sim/virtual_clock.h"

namespace hystcan::can::virtual_clock_test {
namespace {

using namespace std::chrono_literals;

Time at(Duration since_start) { return Time{since_start}; }

TEST(VirtualClock, AdvancesOnlyInRunUntilAndStopsAtTheEnd) {
  VirtualClock clock;
  EXPECT_EQ(clock.now(), at(0ns));
  clock.run_until(at(5ms));
  EXPECT_EQ(clock.now(), at(5ms));
  clock.run_until(at(1ms));
  EXPECT_EQ(clock.now(), at(5ms)) << "time never goes back";
}

TEST(VirtualClock, ExpiresTimersUpToAndIncludingTheEnd) {
  VirtualClock clock;
  std::vector<Time> rung;
  const auto timer = clock.make_timer([&] { rung.push_back(clock.now()); });
  timer->expire_at(at(10us));
  clock.run_until(at(9999ns));
  EXPECT_TRUE(rung.empty());
  clock.run_until(at(10us));
  EXPECT_EQ(rung, std::vector{at(10us)});
}

TEST(VirtualClock, TreatsADeadlineInThePastAsDueNow) {
  VirtualClock clock;
  clock.run_until(at(1s));
  Time rung{};
  const auto timer = clock.make_timer([&] { rung = clock.now(); });
  timer->expire_at(at(1us));
  clock.run_until(at(2s));
  EXPECT_EQ(rung, at(1s));
}

TEST(VirtualClock, DoesNotExpireACancelledOrDestroyedTimer) {
  VirtualClock clock;
  int rings = 0;
  auto cancelled = clock.make_timer([&] { ++rings; });
  auto destroyed = clock.make_timer([&] { ++rings; });
  cancelled->expire_at(at(1us));
  destroyed->expire_at(at(1us));
  cancelled->cancel();
  destroyed.reset();
  clock.run_until(at(1ms));
  EXPECT_EQ(rings, 0);
}

TEST(VirtualClock, AllowsAHandlerToArmAndDestroyTimersIncludingItsOwn) {
  VirtualClock clock;
  int beats = 0;
  std::unique_ptr<Timer> own;
  const std::string content(100, 'x');  // the handler owns it, and must outlive its timer
  std::string seen;
  own = clock.make_timer([&, content] {
    if (++beats < 3) {
      own->expire_at(clock.now() + 1us);
    } else {
      own.reset();
      seen = content;
    }
  });
  own->expire_at(at(1us));
  auto victim = clock.make_timer([] { FAIL() << "destroyed before its deadline"; });
  victim->expire_at(at(2us));
  const auto killer = clock.make_timer([&] { victim.reset(); });
  killer->expire_at(at(1500ns));
  clock.run_until(at(1ms));
  EXPECT_EQ(beats, 3);
  EXPECT_EQ(seen, content);
}

TEST(VirtualClock, MayBeDestroyedBeforeItsTimers) {
  std::unique_ptr<Timer> timer;
  {
    VirtualClock clock;
    timer = clock.make_timer([] { FAIL(); });
    timer->expire_at(at(1us));
  }
  timer->expire_at(at(2us));
  timer->cancel();
}

/// The reference is a sorted list of (deadline, order of arming), for any mix of arming, moving and
/// cancelling.
TEST(VirtualClock, ExpiresTimersInTheOrderOfASortedList) {
  EXPECT_TRUE(rc::check([] {
    constexpr std::size_t count = 12;
    VirtualClock clock;
    std::vector<std::size_t> rung;
    std::vector<std::unique_ptr<Timer>> timers;
    for (std::size_t i = 0; i < count; ++i)
      timers.push_back(clock.make_timer([&rung, i] { rung.push_back(i); }));
    std::map<std::size_t, std::pair<int, int>> armed;
    const auto steps = *rc::gen::inRange(0, 60);
    for (int order = 0; order < steps; ++order) {
      const auto which = *rc::gen::inRange<std::size_t>(0, count);
      if (*rc::gen::inRange(0, 4) == 0) {
        timers[which]->cancel();
        armed.erase(which);
      } else {
        const int deadline_us = *rc::gen::inRange(0, 20);
        timers[which]->expire_at(at(deadline_us * 1us));
        armed[which] = {deadline_us, order};
      }
    }
    std::vector<std::pair<std::pair<int, int>, std::size_t>> sorted;
    for (const auto& [which, key] : armed) sorted.push_back({key, which});
    std::sort(sorted.begin(), sorted.end());
    std::vector<std::size_t> expected;
    for (const auto& [key, which] : sorted) expected.push_back(which);
    clock.run_until(at(1ms));
    RC_ASSERT(rung == expected);
  }));
}

}  // namespace
}  // namespace hystcan::can::virtual_clock_test
