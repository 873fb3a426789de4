// SocketCanBus receives the frames of its filters in order, with their arrival time, and counts lost frames.
#include "tests/can/socketcan/socketcan_fixture.h"

namespace hystcan::can::socketcan_receive_test {
namespace {

using SocketCanReceive = OnVcan;

TEST_F(SocketCanReceive, DeliversOnlyTheIdentifiersOfItsFilters) {
  const auto bus = open("vcan0", {{0x181}, {0x182}});
  for (const char* frame :
       {"180#00", "181#01", "183#02", "581#03", "00000183#04", "00010181#05", "183#R8", "182#06"}) {
    ASSERT_TRUE(shell(std::string("cansend vcan0 ") + frame)) << frame;
  }
  run_until([&] { return heard.size() >= 2; });
  ASSERT_EQ(heard.size(), 2U);
  EXPECT_EQ(heard[0], (Frame{.id = 0x181, .length = 1, .data = {1}}));
  EXPECT_EQ(heard[1], (Frame{.id = 0x182, .length = 1, .data = {6}}));
}

TEST_F(SocketCanReceive, DeliversAnExtendedAndARemoteFrameOfAFilteredIdentifierOnce) {
  const auto bus = open("vcan0", {{0x181}});
  for (const char* frame : {"00000181#0102", "181#R8", "181#07"}) {
    ASSERT_TRUE(shell(std::string("cansend vcan0 ") + frame)) << frame;
  }
  run_until([&] { return heard.size() >= 3; });
  ASSERT_EQ(heard.size(), 3U);
  EXPECT_EQ(heard[0], (Frame{.id = 0x181, .extended = true, .length = 2, .data = {1, 2}}));
  EXPECT_EQ(heard[1], (Frame{.id = 0x181, .kind = FrameKind::remote, .length = 8}));
  EXPECT_EQ(heard[2], (Frame{.id = 0x181, .length = 1, .data = {7}}));
}

TEST_F(SocketCanReceive, ReadsManyFramesInOrderInOneWakeUp) {
  const auto bus = open("vcan0", {{0x181}});
  ASSERT_TRUE(shell("cangen vcan0 -g 0 -I 181 -L 2 -D i -n 100"));
  run_until([&] { return heard.size() >= 100; });
  ASSERT_EQ(heard.size(), 100U);
  for (std::size_t i = 0; i < heard.size(); ++i) EXPECT_EQ(heard[i].data[0], i);
  EXPECT_EQ(bus->counters().received, 100U);
  EXPECT_EQ(bus->counters().receive_lost, 0U);
}

TEST_F(SocketCanReceive, GivesTheArrivalTimeAndNotTheReadingTime) {
  const auto bus = open("vcan0", {{0x181}});
  const Time before = std::chrono::steady_clock::now();
  ASSERT_TRUE(shell("cansend vcan0 181#00"));
  const Time after = std::chrono::steady_clock::now();
  std::this_thread::sleep_for(50ms);  // or longer: only the bus reads late
  run_until([&] { return !heard.empty(); });
  EXPECT_GE(stamps[0], before);
  EXPECT_LE(stamps[0], after);
}

TEST_F(SocketCanReceive, ReturnsFromTheSocketAtTheDeadline) {
  const auto bus = open("vcan0", {{0x181}});
  for (int i = 0; i < 3; ++i) {
    const Time deadline = std::chrono::steady_clock::now() + 5ms;
    EXPECT_FALSE(bus->receive_before(deadline));
    EXPECT_GE(std::chrono::steady_clock::now(), deadline);
  }
  EXPECT_FALSE(bus->receive_before(Time{})) << "a deadline in the past";
}

TEST_F(SocketCanReceive, ReceivesInTheSocketOneFrameACall) {
  const auto bus = open("vcan0", {{0x181}});
  ASSERT_TRUE(shell("cansend vcan0 181#01 && cansend vcan0 181#02"));
  const Time deadline = std::chrono::steady_clock::now() + support::patience;
  EXPECT_TRUE(bus->receive_before(deadline));
  ASSERT_EQ(heard.size(), 1U);
  EXPECT_TRUE(bus->receive_before(deadline));
  ASSERT_EQ(heard.size(), 2U);
  EXPECT_EQ(heard[1].data[0], 2);
}

TEST_F(SocketCanReceive, ReturnsAtTheDeadlineBetweenFramesThatNeverEnd) {
  const auto bus = open("vcan0", {{0x181}});
  bus->on_frame([](const Frame&, Time) { EXPECT_TRUE(shell("cansend vcan0 181#02")); });
  ASSERT_TRUE(shell("cansend vcan0 181#01"));
  const Time deadline = std::chrono::steady_clock::now() + 50ms;
  while (bus->receive_before(deadline)) continue;
  EXPECT_GE(std::chrono::steady_clock::now(), deadline);
}

TEST_F(SocketCanReceive, DeliversAllFramesThatHaveArrivedIfItIsCalledAfterTheDeadline) {
  const auto bus = open("vcan0", {{0x181}});
  ASSERT_TRUE(shell("cangen vcan0 -g 0 -I 181 -n 40"));
  EXPECT_FALSE(bus->receive_before(std::chrono::steady_clock::now()));
  EXPECT_EQ(heard.size(), 40U);
}

TEST_F(SocketCanReceive, ReturnsAfterTheDeadlineIfFramesNeverEnd) {
  const auto bus = open("vcan0", {{0x181}});
  bus->on_frame([](const Frame&, Time) { EXPECT_TRUE(shell("cangen vcan0 -g 0 -I 181 -n 2")); });
  ASSERT_TRUE(shell("cansend vcan0 181#01"));
  EXPECT_FALSE(bus->receive_before(std::chrono::steady_clock::now()));
}

TEST_F(SocketCanReceive, CountsFramesThatTheKernelDropped) {
  const auto bus = open("vcan0", {{0x181}});
  ASSERT_TRUE(shell("cangen vcan0 -g 0 -I 181 -L 8 -n 3000"));
  run_until([&] { return heard.size() >= 100; });
  context.poll();
  context.restart();
  const std::size_t kept = heard.size();
  ASSERT_TRUE(shell("cansend vcan0 181#FF"));
  run_until([&] { return heard.size() > kept; });
  EXPECT_GT(bus->counters().receive_lost, 0U);
  EXPECT_EQ(bus->counters().received + bus->counters().receive_lost, 3001U);
}

TEST_F(SocketCanReceive, AllowsAHandlerToDestroyTheBus) {
  auto bus = open("vcan0", {{0x181}});
  int frames = 0;
  bus->on_frame([&](const Frame&, Time) {
    ++frames;
    bus.reset();
  });
  ASSERT_TRUE(shell("cangen vcan0 -g 0 -I 181 -n 5"));
  run_until([&] { return !bus; });
  context.run();
  EXPECT_EQ(frames, 1);
}

TEST_F(SocketCanInterface, DeliversAnFdFrameOfAFilteredIdentifier) {
  const auto bus = open("vcan9", {{0x181}});
  ASSERT_TRUE(shell("cansend vcan9 181##0010203"));
  run_until([&] { return !heard.empty(); });
  EXPECT_EQ(heard[0].kind, FrameKind::fd);
  EXPECT_EQ(heard[0].length, 3);
}

TEST_F(SocketCanInterface, CountsLostFramesOnceAfterItWasOpenedAgain) {
  const auto bus = open("vcan9", {{0x181}});
  ASSERT_TRUE(shell("cangen vcan9 -g 0 -I 181 -L 8 -n 3000"));
  run_until([&] { return heard.size() >= 100; });
  context.poll();
  context.restart();
  ASSERT_TRUE(shell("cansend vcan9 181#FF"));
  run_until([&] { return bus->counters().receive_lost > 0; });
  const std::uint64_t lost = bus->counters().receive_lost;
  ASSERT_TRUE(shell("ip link set vcan9 down"));
  run_until([&] { return bus->state() == BusState::down; });
  ASSERT_TRUE(shell("ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
  const std::size_t kept = heard.size();
  ASSERT_TRUE(shell("cansend vcan9 181#FE"));
  run_until([&] { return heard.size() > kept; });
  EXPECT_EQ(bus->counters().receive_lost, lost);
}

}  // namespace
}  // namespace hystcan::can::socketcan_receive_test
