// Compares monitor and decode with can-utils.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/hil/live_stage.h"
#include "tests/support/scratch.h"
#include "tests/support/shipped.h"

namespace hystcan::bus_tools_test {
namespace {

using hil::config_file;
using hil::json;
using hil::Process;

const std::string dbc_file = HYSTCAN_SOURCE_DIR "/config/hystcan.dbc";

class BusTools : public testing::Test {
 protected:
  std::string path(const char* name) const { return (folder_ / name).string(); }
  void write(const char* name, const std::string& text) const { std::ofstream(folder_ / name) << text; }

  static int shell(const std::string& command) {
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  support::ScratchFolder folder_;
  hil::Listeners listeners{"vcan0"};
};

TEST_F(BusTools, DecodeReadsCandumpThroughAPipe) {
  Process pipe({"sh", "-c", "candump -L -n 1 vcan0 | " HYSTCAN_PROGRAM " decode - --dbc " + dbc_file});
  ASSERT_TRUE(listeners.are_more_by(1));
  ASSERT_EQ(shell("cansend vcan0 201#4E61BC00010703D9"), 0);
  EXPECT_EQ(pipe.wait(), 0) << pipe.err();
  EXPECT_NE(pipe.out().find("vcan0 XAmpCommand Setpoint=12.345678 V, Enable=1"), std::string::npos)
      << pipe.out();
}

TEST_F(BusTools, MonitorCountsRatesAndRejectionsByCause) {
  Process monitor(
      {HYSTCAN_PROGRAM, "monitor", config_file, "--interface", "vcan0", "--once", "--json", "--period", "4"});
  ASSERT_TRUE(listeners.are_more_by(1));
  for (const char* frame :
       {"201#4E61BC00010703D9", "201#4E61BC00010703D9", "201#4E61BC00010703DA", "201#4E61BC", "201#R",
        "00000201#4E61BC00010703D9", "345#AB", "20000004#0030000000008800"})
    ASSERT_EQ(shell(std::string("cansend vcan0 ") + frame), 0);
  EXPECT_EQ(monitor.wait(), 0) << monitor.err();
  const json table = json::parse(monitor.out());
  EXPECT_EQ(table.at("frames"), 7);
  EXPECT_EQ(table.at("error_frames"), 1);
  EXPECT_EQ(table.at("state"), "passive");
  EXPECT_EQ(table.at("error_counters").at("transmit"), 0x88);
  ASSERT_EQ(table.at("messages").size(), 2U);
  const json& command = table.at("messages")[0];
  EXPECT_EQ(command.at("message"), "XAmpCommand");
  EXPECT_EQ(command.at("count"), 6);
  for (const char* cause :
       {"repeated counter", "wrong CRC", "wrong length", "not a data frame", "wrong identifier type"})
    EXPECT_EQ(command.at("rejected").at(cause), 1) << cause;
  EXPECT_DOUBLE_EQ(command.at("signals").at("Setpoint").at("value"), 12345678 * 1e-6);
  EXPECT_TRUE(table.at("messages")[1].at("message").is_null());
  EXPECT_NEAR(table.at("rate_Hz"), 1.75, 0.1) << "7 frames in 4 s, or a little more";
}

TEST_F(BusTools, MonitorPrintsPlainTextWithoutATerminal) {
  Process monitor({HYSTCAN_PROGRAM, "monitor", "--dbc", dbc_file, "--interface", "vcan0", "--period", "0.5"});
  ASSERT_TRUE(listeners.are_more_by(1));
  ASSERT_EQ(shell("cansend vcan0 201#4E61BC00010703D9"), 0);
  EXPECT_TRUE(hil::eventually([&] { return monitor.out().find("Setpoint=") != std::string::npos; }));
  monitor.send(SIGINT);
  EXPECT_EQ(monitor.wait(), 0) << monitor.err();
  EXPECT_NE(monitor.out().find("vcan0: active"), std::string::npos) << monitor.out();
  EXPECT_NE(monitor.out().find("Setpoint=12.345678 V"), std::string::npos) << monitor.out();
  EXPECT_EQ(monitor.out().find('\x1b'), std::string::npos);
}

/// A message that must be CAN FD because of its length.
const char* const fd_dbc =
    "BO_ 291 Long: 12 A\n SG_ Value : 0|32@1- (0.001,0) [0|0] \"um\" A\n SG_ Last : 88|8@1+ (1,0) [0|0] \"\" A\n";

TEST_F(BusTools, ShowFdFramesOfCansendWithTheirBitRateSwitch) {
  write("fd.dbc", fd_dbc);
  Process monitor({HYSTCAN_PROGRAM, "monitor", "--dbc", path("fd.dbc"), "--interface", "vcan0", "--once",
                   "--json", "--period", "2"});
  Process pipe(
      {"sh", "-c", "candump -L -n 2 vcan0 | " HYSTCAN_PROGRAM " decode - --json --dbc " + path("fd.dbc")});
  ASSERT_TRUE(listeners.are_more_by(2));
  ASSERT_EQ(shell("cansend vcan0 123##0E80300000000000000000006"), 0);
  ASSERT_EQ(shell("cansend vcan0 123##1E80300000000000000000007"), 0);
  EXPECT_EQ(pipe.wait(), 0) << pipe.err();
  std::istringstream lines(pipe.out());
  for (const bool switches : {false, true}) {
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(json::parse(line).at("brs"), switches) << line;
    EXPECT_EQ(json::parse(line).at("signals").at("Value").at("raw"), 1000) << line;
  }
  EXPECT_EQ(monitor.wait(), 0) << monitor.err();
  const json message = json::parse(monitor.out()).at("messages").at(0);
  EXPECT_EQ(message.at("count"), 2);
  EXPECT_EQ(message.at("brs"), true);
  EXPECT_EQ(message.at("signals").at("Last").at("value"), 7.0);
}

}  // namespace
}  // namespace hystcan::bus_tools_test
