#include <gtest/gtest.h>

#include <utility>

#include <boost/asio/io_context.hpp>
#include <memory>
#include <string>

#include "can/socketcan/asio_scheduler.h"
#include "can/socketcan/socketcan_bus.h"

namespace hystcan::can::scheduler_test {
namespace {

using namespace std::chrono_literals;

struct AsioTimer : testing::Test {
  boost::asio::io_context context;
  AsioScheduler scheduler{context};
  std::string order;
};

TEST_F(AsioTimer, ExpiresOnceAndNotBeforeItsDeadline) {
  const Time deadline = scheduler.now() + 2ms;
  Time rung{};
  const auto timer = scheduler.make_timer([&] {
    order += 'r';
    rung = scheduler.now();
  });
  timer->expire_at(deadline);
  context.run();
  EXPECT_EQ(order, "r");
  EXPECT_GE(rung, deadline);
}

TEST_F(AsioTimer, KeepsOnlyTheLastDeadline) {
  const Time start = scheduler.now();
  Time rung{};
  const auto timer = scheduler.make_timer([&] {
    order += 'r';
    rung = scheduler.now();
  });
  timer->expire_at(start + 1h);
  timer->expire_at(start + 1ms);  // earlier
  timer->expire_at(start + 4ms);  // later again
  context.run();
  EXPECT_EQ(order, "r");
  EXPECT_GE(rung, start + 4ms);
}

TEST_F(AsioTimer, ExpiresForADeadlineInThePast) {
  const auto timer = scheduler.make_timer([&] { order += 'r'; });
  timer->expire_at(Time{});
  context.run();
  EXPECT_EQ(order, "r");
}

TEST_F(AsioTimer, LeavesNoWorkInTheContextIfItIsCancelledOrDestroyed) {
  auto cancelled = scheduler.make_timer([&] { order += 'c'; });
  auto destroyed = scheduler.make_timer([&] { order += 'd'; });
  cancelled->expire_at(scheduler.now() + 1h);
  destroyed->expire_at(scheduler.now() + 1h);
  cancelled->cancel();
  destroyed.reset();
  context.run();
  EXPECT_EQ(order, "");
}

TEST_F(AsioTimer, CallsExpiredHandlersForAnOwnerThatWaitsItself) {
  scheduler.wait_in_context(false);
  const auto later = scheduler.make_timer([&] { order += 'l'; });
  const auto second = scheduler.make_timer([&] { order += '2'; });
  const auto first = scheduler.make_timer([&] { order += '1'; });
  EXPECT_EQ(scheduler.next_deadline(), Time::max());
  later->expire_at(scheduler.now() + 1h);
  second->expire_at(Time{} + 2ns);
  first->expire_at(Time{} + 1ns);
  EXPECT_EQ(scheduler.next_deadline(), Time{} + 1ns);
  context.run();  // has no work
  EXPECT_EQ(order, "");
  scheduler.run_expired();
  EXPECT_EQ(order, "12");
}

TEST_F(AsioTimer, WaitsInTheContextAgainAfterItsOwnerHasWaited) {
  scheduler.wait_in_context(false);
  const auto timer = scheduler.make_timer([&] { order += 'r'; });
  timer->expire_at(scheduler.now() + 1ms);
  scheduler.wait_in_context(true);
  context.run();
  EXPECT_EQ(order, "r");
}

TEST_F(AsioTimer, DoesNotRunItsHandlerIfItIsCancelledAfterItsDeadline) {
  const auto victim = scheduler.make_timer([&] { order += 'v'; });
  const auto killer = scheduler.make_timer([&] {
    order += 'k';
    victim->cancel();
  });
  killer->expire_at(Time{});
  victim->expire_at(Time{} + 1ns);
  context.run();
  EXPECT_EQ(order, "k");
}

TEST_F(AsioTimer, MayBeArmedAndDestroyedInItsHandler) {
  std::unique_ptr<Timer> timer;
  const std::string content(100, 'x');  // the handler owns it, and must outlive its timer
  std::string seen;
  timer = scheduler.make_timer([&, content] {
    order += 'r';
    if (order.size() < 3) {
      timer->expire_at(scheduler.now());
    } else {
      timer.reset();
      seen = content;
    }
  });
  timer->expire_at(scheduler.now());
  context.run();
  EXPECT_EQ(order, "rrr");
  EXPECT_EQ(seen, content);
}

TEST_F(AsioTimer, MayBeArmedAgainAfterItWasCancelled) {
  const auto timer = scheduler.make_timer([&] { order += 'r'; });
  timer->expire_at(scheduler.now() + 1h);
  timer->cancel();
  timer->expire_at(scheduler.now());
  context.run();
  EXPECT_EQ(order, "r");
}

}  // namespace
}  // namespace hystcan::can::scheduler_test
