// SocketCanBus sends frames byte for byte to all other sockets and refuses invalid frames. can-utils and
// python-can are the other side.
#include <fmt/format.h>

#include "can/dbc/database.h"
#include "tests/can/socketcan/socketcan_fixture.h"
#include "tests/support/process.h"

namespace hystcan::can::socketcan_send_test {
namespace {

using SocketCanSend = OnVcan;

/// Runs candump in the background until it has received a number of frames.
class Candump {
 public:
  explicit Candump(int frames) : process_({"candump", "-L", "-n", std::to_string(frames), "vcan0"}) {
    EXPECT_TRUE(support::eventually([] {
      return support::read_file("/proc/net/can/rcvlist_all").find("  vcan0 ") != std::string::npos;
    }));
  }
  std::vector<std::string> frames() {
    EXPECT_TRUE(support::eventually([&] { return !process_.running(); })) << process_.out();
    std::istringstream lines(process_.out());
    std::vector<std::string> result;
    for (std::string line; std::getline(lines, line);) result.push_back(line.substr(line.rfind(' ') + 1));
    return result;
  }

 private:
  support::Process process_;
};

TEST_F(SocketCanSend, SendsFramesThatCandumpShowsByteForByte) {
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

TEST_F(SocketCanSend, ReachesEveryOtherSocketButNotTheSender) {
  const auto bus = open("vcan0", {{0x201}});
  boost::asio::io_context other_context;
  SocketCanBus other(other_context, "vcan0", std::vector<Filter>{{0x201}});
  int heard_by_other = 0;
  other.on_frame([&](const Frame&, Time) { ++heard_by_other; });
  EXPECT_TRUE(bus->send({.id = 0x201, .length = 8}));
  while (heard_by_other == 0 && other_context.run_one_for(std::chrono::seconds(10)) > 0) continue;
  context.poll();
  EXPECT_EQ(heard_by_other, 1);
  EXPECT_TRUE(heard.empty());
}

TEST_F(SocketCanSend, RefusesAndCountsInvalidFramesAndFramesTooLongForTheInterface) {
  const auto bus = open("vcan0", {});
  EXPECT_FALSE(bus->send({.id = 0x800, .length = 1}));
  EXPECT_FALSE(bus->send({.id = 0x100, .length = 9}));
  EXPECT_FALSE(bus->send({.kind = FrameKind::error}));
  EXPECT_EQ(bus->counters().send_refused, 3U);
  EXPECT_EQ(bus->state(), BusState::active);
}

// python-can is an independent node: it receives every message of the shipped DBC and sends it back with its
// payload inverted.
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
  support::Process python_node({"/usr/bin/python3", HYSTCAN_SOURCE_DIR "/tests/can/socketcan/python_node.py",
                                "vcan9", std::to_string(sent.size())});
  ASSERT_TRUE(support::eventually([&] { return !python_node.out().empty(); })) << python_node.err();
  for (const Frame& frame : sent) EXPECT_TRUE(bus->send(frame));
  run_until([&] { return heard.size() >= sent.size(); });
  EXPECT_TRUE(support::eventually([&] { return !python_node.running(); }));
  EXPECT_EQ(python_node.out(), expected) << "what python-can received";
  ASSERT_EQ(heard.size(), sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    Frame inverted = sent[i];
    for (std::uint8_t byte = 0; byte < inverted.length; ++byte)
      inverted.data[byte] = static_cast<std::uint8_t>(255 - inverted.data[byte]);
    EXPECT_EQ(heard[i], inverted) << database.messages[i].name;
  }
}

}  // namespace
}  // namespace hystcan::can::socketcan_send_test
