// On the real interface vcan0, with can-utils as the other side. Where the kernel has none of it, these skip.
#include "can/socketcan_bus.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <utility>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "can/dbc.h"
#include "can/interface.h"

namespace hystcan::can {
namespace {

using namespace std::chrono_literals;

std::string reason_to_skip() {
  const int probe = ::socket(PF_CAN, SOCK_RAW, 1);
  if (probe < 0) return "this kernel has no AF_CAN";
  ::close(probe);
  const auto found = query_interface("vcan0");
  return found && found->up ? "" : "there is no interface vcan0 that is up";
}

bool shell(const std::string& command) { return std::system((command + " 2>/dev/null").c_str()) == 0; }

std::string content_of(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// candump in the background, until it has seen a number of frames.
class Candump {
 public:
  explicit Candump(int frames)
      : log_(std::filesystem::temp_directory_path() / ("candump-" + std::to_string(::getpid()))) {
    child_ = ::fork();
    if (child_ == 0) {
      const std::string command =
          "exec candump -L -T 20000 -n " + std::to_string(frames) + " vcan0 > " + log_.string();
      ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      ::_exit(127);
    }
    while (content_of("/proc/net/can/rcvlist_all").find("  vcan0 ") == std::string::npos) {
      std::this_thread::sleep_for(1ms);
    }
  }
  ~Candump() {
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
    std::filesystem::remove(log_);
  }
  Candump(const Candump&) = delete;
  Candump& operator=(const Candump&) = delete;

  std::vector<std::string> frames() {
    ::waitpid(child_, nullptr, 0);
    std::ifstream file(log_);
    std::vector<std::string> result;
    for (std::string line; std::getline(file, line);) result.push_back(line.substr(line.rfind(' ') + 1));
    return result;
  }

 private:
  std::filesystem::path log_;
  pid_t child_ = -1;
};

/// Runs handlers until `done` holds; gives up after a generous time, which no passing test comes near.
template <class Condition>
void run_until(boost::asio::io_context& context, Condition done) {
  const Time give_up = std::chrono::steady_clock::now() + 20s;
  while (!done() && std::chrono::steady_clock::now() < give_up) context.run_one_for(100ms);
  context.restart();
  EXPECT_TRUE(done());
}

struct OnVcan : testing::Test {
  void SetUp() override {
    if (const std::string reason = reason_to_skip(); !reason.empty()) GTEST_SKIP() << reason;
  }

  std::unique_ptr<SocketCanBus> open(const std::string& interface, std::vector<Filter> filters) {
    auto bus = std::make_unique<SocketCanBus>(context, interface, filters);
    bus->on_frame([this](const Frame& frame, Time received) {
      heard.push_back(frame);
      stamps.push_back(received);
    });
    bus->on_state([this](BusState state) { states.push_back(state); });
    return bus;
  }

  template <class Condition>
  void run_until(Condition done) {
    hystcan::can::run_until(context, done);
  }

  boost::asio::io_context context;
  std::vector<Frame> heard;
  std::vector<Time> stamps;
  std::vector<BusState> states;
};
using SocketCanSend = OnVcan;
using SocketCanReceive = OnVcan;

/// An interface of the test's own, to be taken down, deleted and given FD frames.
struct SocketCanInterface : OnVcan {
  void SetUp() override {
    OnVcan::SetUp();
    if (IsSkipped()) return;
    if (!shell("ip link add dev vcan9 type vcan")) GTEST_SKIP() << "may not create an interface";
    ASSERT_TRUE(shell("ip link set vcan9 mtu 72 && ip link set vcan9 up"));
  }
  void TearDown() override { shell("ip link del vcan9"); }
};

std::string refusal(const std::string& interface) {
  boost::asio::io_context context;
  try {
    SocketCanBus bus(context, interface, {});
  } catch (const InterfaceError& error) {
    return error.what();
  }
  return "opened";
}

TEST_F(SocketCanSend, ShowsInCandumpByteForByte) {
  const auto bus = open("vcan0", {});
  Candump candump(4);
  EXPECT_TRUE(
      bus->send({.id = 0x201, .length = 8, .data = {0x4E, 0x61, 0xBC, 0x00, 0x01, 0x07, 0x03, 0xD9}}));
  EXPECT_TRUE(bus->send({.id = 0x123, .kind = FrameKind::remote, .length = 3}));
  EXPECT_TRUE(bus->send({.id = 0x18FEEDFE, .extended = true, .length = 2, .data = {0xAB, 0xCD}}));
  EXPECT_TRUE(bus->send({.id = 0x080, .length = 1, .data = {240}}));
  EXPECT_EQ(candump.frames(),
            (std::vector<std::string>{"201#4E61BC00010703D9", "123#R3", "18FEEDFE#ABCD", "080#F0"}));
  EXPECT_EQ(bus->counters().sent, 4U);
}

TEST_F(SocketCanSend, IsNotHeardByTheSenderButByEveryOtherSocket) {
  const auto bus = open("vcan0", {{0x201}});
  boost::asio::io_context other_context;
  SocketCanBus other(other_context, "vcan0", std::vector<Filter>{{0x201}});
  int heard_by_other = 0;
  other.on_frame([&](const Frame&, Time) { ++heard_by_other; });
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 8}));
  other_context.poll();
  context.poll();
  EXPECT_EQ(heard_by_other, 1);
  EXPECT_TRUE(heard.empty());
}

TEST_F(SocketCanSend, RefusesAndCountsWhatIsNoFrameOrTooLongForTheInterface) {
  const auto bus = open("vcan0", {});
  EXPECT_FALSE(bus->send({.id = 0x800, .length = 1}));
  EXPECT_FALSE(bus->send({.id = 0x100, .length = 9}));
  EXPECT_FALSE(bus->send({.kind = FrameKind::error}));
  EXPECT_EQ(bus->counters().send_refused, 3U);
  EXPECT_EQ(bus->state(), BusState::active);
}

TEST_F(SocketCanReceive, LetsOnlyTheFilteredIdentifiersThrough) {
  const auto bus = open("vcan0", {{0x181}, {0x182}});
  for (const char* frame : {"180#00", "181#01", "183#02", "581#03", "00000183#04", "00010181#05", "182#06"}) {
    ASSERT_TRUE(shell(std::string("cansend vcan0 ") + frame)) << frame;
  }
  run_until([&] { return heard.size() >= 2; });
  ASSERT_EQ(heard.size(), 2U);
  EXPECT_EQ(heard[0], (Frame{.id = 0x181, .length = 1, .data = {1}}));
  EXPECT_EQ(heard[1], (Frame{.id = 0x182, .length = 1, .data = {6}}));
}

TEST_F(SocketCanReceive, DeliversAnExtendedAndARemoteFrameInThePlaceOfOursOnce) {
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

TEST_F(SocketCanReceive, TakesManyFramesInOrderInOneWakeUp) {
  const auto bus = open("vcan0", {{0x181}});
  ASSERT_TRUE(shell("cangen vcan0 -g 0 -I 181 -L 2 -D i -n 100"));
  run_until([&] { return heard.size() >= 100; });
  ASSERT_EQ(heard.size(), 100U);
  for (std::size_t i = 0; i < heard.size(); ++i) EXPECT_EQ(heard[i].data[0], i);
  EXPECT_EQ(bus->counters().received, 100U);
  EXPECT_EQ(bus->counters().receive_lost, 0U);
}

TEST_F(SocketCanReceive, StampsAFrameWithTheTimeOfItsArrivalNotOfItsReading) {
  const auto bus = open("vcan0", {{0x181}});
  const Time before = std::chrono::steady_clock::now();
  ASSERT_TRUE(shell("cansend vcan0 181#00"));
  const Time after = std::chrono::steady_clock::now();
  std::this_thread::sleep_for(50ms);
  run_until([&] { return !heard.empty(); });
  EXPECT_GE(stamps[0], before);
  EXPECT_LE(stamps[0], after);
}

TEST_F(SocketCanReceive, CountsWhatTheKernelDropped) {
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

TEST_F(SocketCanReceive, LetsAHandlerDestroyTheBus) {
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

TEST_F(SocketCanInterface, DeliversAnFdFrameInThePlaceOfOurs) {
  const auto bus = open("vcan9", {{0x181}});
  ASSERT_TRUE(shell("cansend vcan9 181##0010203"));
  run_until([&] { return !heard.empty(); });
  EXPECT_EQ(heard[0].kind, FrameKind::fd);
  EXPECT_EQ(heard[0].length, 3);
}

TEST_F(SocketCanInterface, MayGoDownAndComeUpAgain) {
  const auto bus = open("vcan9", {{0x181}});
  EXPECT_EQ(bus->state(), BusState::active);
  ASSERT_TRUE(shell("ip link set vcan9 down"));
  run_until([&] { return bus->state() == BusState::down; });
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 8}));
  EXPECT_EQ(bus->counters().send_refused, 1U);

  ASSERT_TRUE(shell("ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 8}));
  ASSERT_TRUE(shell("cansend vcan9 181#11 && cansend vcan9 182#12"));
  run_until([&] { return !heard.empty(); });
  EXPECT_EQ(states, (std::vector{BusState::down, BusState::active}));
}

TEST_F(SocketCanInterface, GoingDownIsNoticedBySendingToo) {
  const auto bus = open("vcan9", {});
  ASSERT_TRUE(shell("ip link set vcan9 down"));
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 8}));
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 8}));
  run_until([&] { return bus->state() == BusState::down; });
  EXPECT_EQ(bus->counters().send_refused, 2U);
  ASSERT_TRUE(shell("ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 8}));
}

TEST_F(SocketCanInterface, MayVanishAndComeBackUnderItsName) {
  const auto bus = open("vcan9", {{0x181}});
  ASSERT_TRUE(shell("ip link del vcan9"));
  run_until([&] { return bus->state() == BusState::down; });
  ASSERT_TRUE(shell("ip link add dev vcan9 type vcan && ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
  ASSERT_TRUE(shell("cansend vcan9 181#22"));
  run_until([&] { return !heard.empty(); });
  EXPECT_EQ(heard[0].data[0], 0x22);
}

// Error frames as canerrsim of can-utils forms them: CAN_ERR_FLAG and the class in the identifier, eight
// bytes.
TEST_F(SocketCanInterface, TellsStateAndErrorCountersFromErrorFrames) {
  const auto bus = open("vcan9", {{0x181}});
  EXPECT_EQ(bus->error_counters(), std::nullopt);
  ASSERT_TRUE(shell("cansend vcan9 20000204#0008000000006003"));
  run_until([&] { return bus->state() == BusState::warning; });
  EXPECT_EQ(bus->error_counters(), (ErrorCounters{.transmit = 96, .receive = 3}));
  ASSERT_TRUE(shell("cansend vcan9 20000204#0020000000008803"));
  run_until([&] { return bus->state() == BusState::passive; });
  EXPECT_EQ(bus->error_counters(), (ErrorCounters{.transmit = 136, .receive = 3}));
  ASSERT_TRUE(shell("cansend vcan9 20000040#0000000000000000"));
  run_until([&] { return bus->state() == BusState::bus_off; });
  context.run_for(200ms);
  context.restart();
  EXPECT_EQ(bus->state(), BusState::bus_off) << "vcan states none, so only the restart ends it";
  ASSERT_TRUE(shell("cansend vcan9 20000100#0000000000000000"));
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_EQ(states, (std::vector{BusState::warning, BusState::passive, BusState::bus_off, BusState::active}));
  EXPECT_EQ(bus->counters().warnings, 1U);
  EXPECT_EQ(bus->counters().passives, 1U);
  EXPECT_EQ(bus->counters().bus_offs, 1U);
  EXPECT_EQ(bus->counters().restarts, 1U);
  EXPECT_EQ(bus->counters().error_frames, 4U);
  EXPECT_TRUE(heard.empty()) << "error frames are not for the frame handler";
}

TEST_F(SocketCanInterface, CountsWhatErrorFramesTellOfTheWire) {
  const auto bus = open("vcan9", {{0x181}});
  for (const char* frame :
       {"20000020#0000000000000000", "20000002#0500000000000000", "20000088#0000040800000000",
        "20000004#0001000000000000", "20000010#0000000004000000"}) {
    ASSERT_TRUE(shell(std::string("cansend vcan9 ") + frame)) << frame;
  }
  run_until([&] { return bus->counters().error_frames >= 5; });
  EXPECT_EQ(bus->counters().not_acknowledged, 1U);
  EXPECT_EQ(bus->counters().arbitration_lost, 1U);
  EXPECT_EQ(bus->counters().protocol_errors, 1U);
  EXPECT_EQ(bus->counters().controller_overflows, 1U);
  EXPECT_EQ(bus->counters().transceiver_errors, 1U);
  EXPECT_EQ(bus->state(), BusState::active);
}

TEST_F(SocketCanInterface, EndsBusOffByGoingDownAndUp) {
  const auto bus = open("vcan9", {});
  ASSERT_TRUE(shell("cansend vcan9 20000040#0000000000000000"));
  run_until([&] { return bus->state() == BusState::bus_off; });
  ASSERT_TRUE(shell("ip link set vcan9 down"));
  run_until([&] { return bus->state() == BusState::down; });
  ASSERT_TRUE(shell("ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
}

TEST_F(SocketCanInterface, CountsLostFramesOnceAlthoughItWasOpenedAnew) {
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

TEST_F(SocketCanInterface, SetsItsFiltersAgainWhereTheInterfaceIsANewOne) {
  const auto bus = open("vcan9", {{0x181}});
  const int index = query_interface("vcan9")->index;
  ASSERT_TRUE(shell("ip link del vcan9"));
  run_until([&] { return bus->state() == BusState::down; });
  EXPECT_FALSE(bus->send({.id = 0x201, .length = 8})) << "there is nothing to send on";
  ASSERT_TRUE(shell("ip link add dev vcan9 type vcan && ip link set vcan9 up"));
  run_until([&] { return bus->state() == BusState::active; });
  EXPECT_NE(query_interface("vcan9")->index, index) << "as after unplugging and plugging a USB adapter";
  ASSERT_TRUE(shell("cansend vcan9 180#01 && cansend vcan9 182#02 && cansend vcan9 181#03"));
  run_until([&] { return !heard.empty(); });
  context.poll();
  ASSERT_EQ(heard.size(), 1U);
  EXPECT_EQ(heard[0].data[0], 3);
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 8}));
}

TEST_F(SocketCanInterface, IsRefusedWithItsCureWhereItIsDownOrAbsent) {
  ASSERT_TRUE(shell("ip link set vcan9 down"));
  EXPECT_EQ(refusal("vcan9"), "interface vcan9 is down; bring it up with: ip link set vcan9 up");
  EXPECT_EQ(refusal("vcan7"),
            "interface vcan7 does not exist; create it with: ip link add dev vcan7 type vcan && ip link set "
            "vcan7 up");
  EXPECT_EQ(refusal("lo"), "interface lo is not a CAN interface");
}

TEST_F(SocketCanInterface, IsKnownForAVirtualOne) {
  EXPECT_TRUE(is_virtual_interface("vcan0"));
  EXPECT_TRUE(is_virtual_interface("vcan9"));
}

// python-can as an independent peer: every message of the shipped DBC there, and back with its payload
// inverted.
TEST_F(SocketCanInterface, ExchangesEveryMessageOfTheDbcWithPythonCan) {
  const Database database = load_dbc(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc");
  std::vector<Filter> filters;
  std::vector<Frame> sent;
  std::string expected = "ready\n";
  for (const Message& message : database.messages) {
    Frame frame{
        .id = message.id, .extended = message.extended, .length = static_cast<std::uint8_t>(message.length)};
    std::string line = fmt::format("{:0{}X}#", message.id, message.extended ? 8 : 3);
    for (std::uint8_t i = 0; i < message.length; ++i) {
      frame.data[i] = static_cast<std::uint8_t>(16 * sent.size() + i);
      line += fmt::format("{:02X}", frame.data[i]);
    }
    filters.push_back({.id = message.id, .extended = message.extended});
    sent.push_back(frame);
    expected += line + "\n";
  }
  const auto bus = open("vcan9", filters);
  const std::string output = std::filesystem::temp_directory_path() / "python-peer";
  std::thread peer([&] {
    shell("/usr/bin/python3 " HYSTCAN_SOURCE_DIR "/tests/can/python_peer.py vcan9 " +
          std::to_string(sent.size()) + " > " + output);
  });
  const Time give_up = std::chrono::steady_clock::now() + 60s;
  while (content_of(output).empty() && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(10ms);
  for (const Frame& frame : sent) EXPECT_TRUE(bus->send(frame));
  run_until([&] { return heard.size() >= sent.size(); });
  peer.join();
  EXPECT_EQ(content_of(output), expected) << "what python-can received";
  ASSERT_EQ(heard.size(), sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    Frame inverted = sent[i];
    for (std::uint8_t byte = 0; byte < inverted.length; ++byte)
      inverted.data[byte] = static_cast<std::uint8_t>(255 - inverted.data[byte]);
    EXPECT_EQ(heard[i], inverted) << database.messages[i].name;
  }
}

// The guest's SJA1000 controllers, where it has them: real ones to the driver, on a wire of their own.
struct SocketCanController : testing::Test {
  void SetUp() override {
    for (const char* name : {"can0", "can1"}) {
      const auto found = query_interface(name);
      if (!found || !found->up) GTEST_SKIP() << "there is no interface " << name << " that is up";
    }
  }
  boost::asio::io_context context;
};

TEST_F(SocketCanController, IsNotVirtual) { EXPECT_FALSE(is_virtual_interface("can0")); }

TEST_F(SocketCanController, IsDescribedAsIpLinkHasSetItUp) {
  const auto found = query_interface("can0");
  EXPECT_EQ(found->kind, "can");
  EXPECT_EQ(found->bus_state, BusState::active);
  EXPECT_EQ(found->bitrate_bit_per_s, 1'000'000U);
  EXPECT_EQ(found->restart_ms, 100U);
  EXPECT_GT(found->transmit_queue_frames, 0U);
  EXPECT_FALSE(found->queue_discipline.empty());
  EXPECT_TRUE(found->driver_statistics.has_value());
  EXPECT_TRUE(find_doubts("can0", *found, 1e6).empty());
  EXPECT_EQ(find_doubts("can0", *found, 500e3).size(), 1U);
  std::printf("%s\n", describe("can0", *found).c_str());
}

TEST_F(SocketCanController, ThatOnlyListensMayNotBeUsedByANodeThatSends) {
  ASSERT_TRUE(shell("ip link set can1 down && ip link set can1 up type can listen-only on"));
  const Interface found = require_can_interface("can1");
  EXPECT_TRUE(found.listen_only);
  EXPECT_THROW(require_able_to_send("can1", found), InterfaceError);
  ASSERT_TRUE(shell("ip link set can1 down && ip link set can1 up type can listen-only off"));
  EXPECT_NO_THROW(require_able_to_send("can1", require_can_interface("can1")));
}

// On a wire that takes its time the queue fills: ENOBUFS or EAGAIN. The emulated cards send at once, refusing
// none.
TEST_F(SocketCanController, SendsOfABurstWhatItAcceptedAndNeverWhatItRefused) {
  SocketCanBus sender(context, "can0", {});
  SocketCanBus receiver(context, "can1", std::vector<Filter>{{0x201}});
  std::vector<Frame> heard;
  receiver.on_frame([&](const Frame& frame, Time) { heard.push_back(frame); });
  std::uint8_t accepted = 0;
  for (std::uint8_t i = 0; i < 200; ++i) {
    accepted =
        static_cast<std::uint8_t>(accepted + (sender.send({.id = 0x201, .length = 1, .data = {i}}) ? 1 : 0));
  }
  std::printf("a burst of 200 at once: %d accepted, %d refused\n", accepted, 200 - accepted);
  EXPECT_EQ(sender.counters().send_refused, 200U - accepted);
  run_until(context, [&] { return heard.size() >= accepted; });
  EXPECT_TRUE(sender.send({.id = 0x201, .length = 1, .data = {0xFF}}));
  run_until(context, [&] { return heard.size() > accepted; });
  EXPECT_EQ(heard.back().data[0], 0xFF);
  EXPECT_EQ(heard.size(), accepted + 1U) << "what was refused never comes";
}

TEST_F(SocketCanController, CarriesFramesToTheOtherOne) {
  SocketCanBus sender(context, "can0", {});
  SocketCanBus receiver(context, "can1", std::vector<Filter>{{0x201}});
  std::vector<Frame> heard;
  receiver.on_frame([&](const Frame& frame, Time) { heard.push_back(frame); });
  const Frame sent{.id = 0x201, .length = 8, .data = {1, 2, 3, 4, 5, 6, 7, 8}};
  EXPECT_TRUE(sender.send({.id = 0x203, .length = 8}));
  EXPECT_TRUE(sender.send(sent));
  run_until(context, [&] { return !heard.empty(); });
  EXPECT_EQ(heard, std::vector{sent});
  EXPECT_EQ(sender.state(), BusState::active);
}

}  // namespace
}  // namespace hystcan::can
