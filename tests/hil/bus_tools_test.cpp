// Compares record, replay, monitor and decode with can-utils.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/hil/live_stage.h"
#include "tests/support/scratch.h"
#include "tests/support/shipped.h"

namespace hystcan::bus_tools_test {
namespace {

using hil::config_file;
using hil::json;
using hil::milliseconds;
using hil::Process;

const std::string dbc_file = HYSTCAN_SOURCE_DIR "/config/hystcan.dbc";

// One frame of every kind, at distances at which their order is certain.
const char* const log_of_candump =
    "(1000000000.000000) vcan0 123#1122\n"
    "(1000000000.010000) vcan0 12345678#\n"
    "(1000000000.020000) vcan0 123#R\n"
    "(1000000000.030000) vcan0 123#R5\n"
    "(1000000000.040000) vcan0 123##5112233445566778899AABBCC\n"
    "(1000000000.050000) vcan0 20000004#0008000000006000\n"
    "(1000000000.120000) vcan0 201#4E61BC00010703D9\n";

class BusTools : public testing::Test {
 protected:
  std::string path(const char* name) const { return (folder_ / name).string(); }
  std::string read(const char* name) const { return support::read_file(folder_ / name); }
  void write(const char* name, const std::string& text) const { std::ofstream(folder_ / name) << text; }

  static int shell(const std::string& command) {
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  Process candump(const char* name, const char* interface = "vcan0") const {
    return Process(
        {"sh", "-c", std::string("exec candump -D -L ") + interface + ",0:0,#FFFFFFFF >" + path(name)});
  }
  Process record(std::vector<std::string> options, const char* interface = "vcan0") const {
    std::vector<std::string> command{HYSTCAN_PROGRAM, "record", "--interface", interface};
    command.insert(command.end(), options.begin(), options.end());
    return Process(command);
  }
  bool comes_to_have(const char* name, std::size_t frames) const {
    return hil::eventually([&] { return frames_of(read(name)).size() >= frames; });
  }
  /// What should not come has had time to.
  static void settle() { std::this_thread::sleep_for(milliseconds(300)); }

  /// The lines of a log without their times.
  static std::vector<std::string> frames_of(const std::string& log) {
    std::vector<std::string> frames;
    std::istringstream lines(log);
    for (std::string line; std::getline(lines, line);) frames.push_back(line.substr(line.find(' ') + 1));
    return frames;
  }
  static std::vector<std::string> without_error_frames(std::vector<std::string> frames) {
    std::erase_if(frames, [](const std::string& frame) { return frame.find(" 2000") != std::string::npos; });
    return frames;
  }

  /// From the first to the last frame that is no error frame.
  static double span_s(const std::string& log) {
    std::vector<double> times_s;
    std::istringstream lines(log);
    for (std::string line; std::getline(lines, line);)
      if (line.find(" 2000") == std::string::npos) times_s.push_back(std::stod(line.substr(1)));
    return times_s.empty() ? 0.0 : times_s.back() - times_s.front();
  }

  support::ScratchFolder folder_;
  hil::Listeners listeners{"vcan0"};
};

TEST_F(BusTools, RecordWritesWhatCandumpWritesByteForByte) {
  Process beside = candump("candump.log");
  Process recorder = record({"--output", path("record.log")});
  ASSERT_TRUE(recorder.says("recording vcan0"));
  ASSERT_TRUE(listeners.are_more_by(2));
  write("in.log", log_of_candump);
  ASSERT_EQ(shell("canplayer -I " + path("in.log")), 0);
  EXPECT_TRUE(comes_to_have("candump.log", 7) && comes_to_have("record.log", 7));
  settle();
  recorder.send(SIGINT);
  EXPECT_EQ(recorder.wait(), 0) << recorder.err();
  EXPECT_EQ(read("record.log"), read("candump.log"));
  EXPECT_EQ(frames_of(read("record.log")).size(), 7U);
  const std::string span = fmt::format("6 frames of vcan0 in {:.3f} s", span_s(read("candump.log")));
  EXPECT_NE(recorder.err().find(span), std::string::npos) << span << recorder.err();
  EXPECT_NE(recorder.err().find("1 error frame\n  transmit errors: warning: 1\n0 frames lost"),
            std::string::npos)
      << recorder.err();
}

TEST_F(BusTools, CanplayerReplaysWhatRecordRecorded) {
  write("in.log", log_of_candump);
  {
    Process recorder = record({"--output", path("record.log")});
    ASSERT_TRUE(recorder.says("recording vcan0"));
    ASSERT_EQ(shell("canplayer -I " + path("in.log")), 0);
    EXPECT_TRUE(comes_to_have("record.log", 7));
    recorder.send(SIGTERM);
    EXPECT_EQ(recorder.wait(), 0) << recorder.err();
  }
  const hil::Listeners others("vcan0");
  Process beside = candump("again.log");
  ASSERT_TRUE(others.are_more_by(1));
  ASSERT_EQ(shell("canplayer -I " + path("record.log")), 0);
  EXPECT_TRUE(comes_to_have("again.log", 7));
  settle();
  EXPECT_EQ(frames_of(read("again.log")), frames_of(read("in.log")));
}

TEST_F(BusTools, ReplaySendsWhatCandumpRecordedExceptErrorFramesAndNeverEarly) {
  write("in.log", log_of_candump);
  Process beside = candump("again.log");
  ASSERT_TRUE(listeners.are_more_by(1));
  const double started_s = hil::now_s();
  Process replay({HYSTCAN_PROGRAM, "replay", path("in.log")});
  EXPECT_EQ(replay.wait(), 0) << replay.err();
  EXPECT_TRUE(comes_to_have("again.log", 6));
  settle();
  const std::string log = read("again.log");
  EXPECT_EQ(frames_of(log), without_error_frames(frames_of(read("in.log"))));
  EXPECT_NE(replay.err().find("6 frames sent, 1 error frame cannot be sent"), std::string::npos)
      << replay.err();
  const double last_s = std::stod(log.substr(log.rfind('(') + 1));
  EXPECT_GT(last_s - started_s, 0.120) << "behind the first one in the log, which may itself be late";
}

TEST_F(BusTools, ReplayFiltersRepeatsAndTakesAnotherInterface) {
  std::string log = log_of_candump;
  for (auto at = log.find("vcan0"); at != std::string::npos; at = log.find("vcan0", at))
    log.replace(at, 5, "can7");
  write("in.log", log);
  Process elsewhere({HYSTCAN_PROGRAM, "replay", path("in.log")});
  EXPECT_EQ(elsewhere.wait(), 1) << "there is no can7";
  Process beside = candump("again.log");
  ASSERT_TRUE(listeners.are_more_by(1));
  Process replay({HYSTCAN_PROGRAM, "replay", path("in.log"), "--interface", "vcan0", "--loop", "2", "--speed",
                  "10", "--filter", "12345678", "201"});
  EXPECT_EQ(replay.wait(), 0) << replay.err();
  EXPECT_TRUE(comes_to_have("again.log", 4));
  settle();
  const std::vector<std::string> pass{"vcan0 12345678#", "vcan0 201#4E61BC00010703D9"};
  std::vector<std::string> twice = pass;
  twice.insert(twice.end(), pass.begin(), pass.end());
  EXPECT_EQ(frames_of(read("again.log")), twice);
  EXPECT_NE(replay.err().find("8 left out by --filter"), std::string::npos) << replay.err();
}

TEST_F(BusTools, RecordRefusesToOverwriteWithoutTheOption) {
  write("here.log", "precious\n");
  Process refused = record({"--output", path("here.log"), "--duration", "0.1"});
  EXPECT_EQ(refused.wait(), 2);
  EXPECT_NE(refused.err().find("--overwrite"), std::string::npos) << refused.err();
  EXPECT_EQ(read("here.log"), "precious\n");
  Process allowed = record({"--output", path("here.log"), "--duration", "0.1", "--overwrite"});
  EXPECT_EQ(allowed.wait(), 0) << allowed.err();
  EXPECT_EQ(read("here.log"), "");
}

TEST_F(BusTools, RecordReportsAFullDiskAndLeavesWholeLines) {
  // A file may not exceed 4096 bytes (8 blocks of 512): the refusal of a full disk with another errno.
  Process recorder({"sh", "-c",
                    "trap '' XFSZ; ulimit -f 8; exec " HYSTCAN_PROGRAM " record --interface vcan0 --output " +
                        path("full.log")});
  ASSERT_TRUE(recorder.says("recording vcan0"));
  ASSERT_EQ(shell("cangen vcan0 -g 1 -n 200 -I 123 -L 8 -D 1122334455667788"), 0);
  EXPECT_EQ(recorder.wait(), 1);
  EXPECT_NE(recorder.err().find("cannot be written"), std::string::npos) << recorder.err();
  const std::string log = read("full.log");
  EXPECT_GT(log.size(), 4000U);
  EXPECT_TRUE(log.ends_with("#1122334455667788\n")) << log.substr(log.size() - 60);
}

TEST_F(BusTools, RecordCountsEveryFrameThatTheKernelDrops) {
  Process recorder = record({"--output", path("record.log")});
  ASSERT_TRUE(recorder.says("recording vcan0"));
  recorder.send(SIGSTOP);
  int sent = 60'000;
  ASSERT_EQ(shell("cangen vcan0 -g 0 -n 60000 -I 123 -L 8"), 0);
  recorder.send(SIGCONT);
  // As long as the kernel still has no room for it, this one is dropped too, and counts.
  EXPECT_TRUE(hil::eventually([&] {
    EXPECT_EQ(shell("cansend vcan0 124#"), 0);
    ++sent;
    settle();
    return read("record.log").find(" 124#") != std::string::npos;
  }));
  recorder.send(SIGINT);
  EXPECT_EQ(recorder.wait(), 0);
  Process decode({HYSTCAN_PROGRAM, "decode", path("record.log"), "--dbc", dbc_file, "--json"});
  EXPECT_EQ(decode.wait(), 0) << decode.err();
  long lost = 0, got = 0;
  std::istringstream lines(decode.out());
  for (std::string line; std::getline(lines, line);) {
    const json frame = json::parse(line);
    frame.contains("lost") ? lost += frame.at("lost").get<long>() : ++got;
  }
  EXPECT_GT(lost, 0);
  EXPECT_EQ(got + lost, sent) << recorder.err();
  EXPECT_NE(recorder.err().find(std::to_string(lost) + " frames lost"), std::string::npos) << recorder.err();
}

TEST_F(BusTools, RecordDecodesByTheConfigurationAndDecodeReadsCandumpThroughAPipe) {
  Process recorder({HYSTCAN_PROGRAM, "record", config_file, "--interface", "vcan0", "--decode", "--output",
                    path("record.log")});
  Process pipe({"sh", "-c", "candump -L -n 1 vcan0 | " HYSTCAN_PROGRAM " decode - --dbc " + dbc_file});
  ASSERT_TRUE(recorder.says("recording vcan0"));
  ASSERT_TRUE(listeners.are_more_by(2));
  ASSERT_EQ(shell("cansend vcan0 201#4E61BC00010703D9"), 0);
  EXPECT_EQ(pipe.wait(), 0) << pipe.err();
  EXPECT_TRUE(comes_to_have("record.log", 1));
  settle();
  recorder.send(SIGINT);
  EXPECT_EQ(recorder.wait(), 0) << recorder.err();
  EXPECT_NE(recorder.out().find("vcan0 XAmpCommand Setpoint=12.345678 V, Enable=1"), std::string::npos)
      << recorder.out();
  EXPECT_EQ(pipe.out(), recorder.out());
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

/// CAN FD by its length.
const char* const fd_dbc =
    "BO_ 291 Long: 12 A\n SG_ Value : 0|32@1- (0.001,0) [0|0] \"um\" A\n SG_ Last : 88|8@1+ (1,0) [0|0] \"\" A\n";

/// Without the flag that Linux 5.18 and later add: `vcan0 123##1AA`.
std::vector<std::string> without_fd_flag(std::vector<std::string> frames) {
  for (std::string& frame : frames)
    if (const auto mark = frame.find("##"); mark != std::string::npos && frame[mark + 2] >= '4')
      frame[mark + 2] = static_cast<char>(frame[mark + 2] - 4);
  return frames;
}

TEST_F(BusTools, ShowFdFramesOfCansendWithTheirBitRateSwitch) {
  write("fd.dbc", fd_dbc);
  Process monitor({HYSTCAN_PROGRAM, "monitor", "--dbc", path("fd.dbc"), "--interface", "vcan0", "--once",
                   "--json", "--period", "2"});
  Process recorder = record({"--dbc", path("fd.dbc"), "--decode", "--output", path("record.log")});
  Process pipe(
      {"sh", "-c", "candump -L -n 2 vcan0 | " HYSTCAN_PROGRAM " decode - --json --dbc " + path("fd.dbc")});
  ASSERT_TRUE(recorder.says("recording vcan0"));
  ASSERT_TRUE(listeners.are_more_by(3));
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
  EXPECT_TRUE(comes_to_have("record.log", 2));
  recorder.send(SIGINT);
  EXPECT_EQ(recorder.wait(), 0) << recorder.err();
  EXPECT_NE(recorder.out().find("vcan0 Long Value=1 um, Last=7"), std::string::npos) << recorder.out();
  EXPECT_EQ(without_fd_flag(frames_of(read("record.log"))),
            (std::vector<std::string>{"vcan0 123##0E80300000000000000000006",
                                      "vcan0 123##1E80300000000000000000007"}));
}

TEST_F(BusTools, ExchangeFdFramesWithBitRateSwitchWithPythonCan) {
  Process recorder = record({"--output", path("record.log")});
  Process node({"/usr/bin/python3", HYSTCAN_SOURCE_DIR "/tests/can/socketcan/python_node.py", "vcan0", "4"});
  ASSERT_TRUE(recorder.says("recording vcan0"));
  ASSERT_TRUE(hil::eventually([&] { return node.out().starts_with("ready\n"); })) << node.err();
  write("in.log",
        "(1000000000.000000) vcan0 123##1E80300000000000000000007\n"
        "(1000000000.010000) vcan0 12345678##0FF\n"
        "(1000000000.020000) vcan0 123##3\n"
        "(1000000000.030000) vcan0 123#00\n");
  Process replay({HYSTCAN_PROGRAM, "replay", path("in.log")});
  EXPECT_EQ(replay.wait(), 0) << replay.err();
  EXPECT_EQ(node.wait(), 0) << node.err();
  EXPECT_EQ(node.out(), "ready\n123##1E80300000000000000000007\n12345678##0FF\n123##3\n123#00\n");
  EXPECT_TRUE(comes_to_have("record.log", 8));
  recorder.send(SIGINT);
  EXPECT_EQ(recorder.wait(), 0) << recorder.err();
  std::vector<std::string> expected = frames_of(read("in.log"));
  for (const char* inverted : {"123##117FCFFFFFFFFFFFFFFFFFFF8", "12345678##000", "123##3", "123#FF"})
    expected.push_back(std::string("vcan0 ") + inverted);
  EXPECT_EQ(without_fd_flag(frames_of(read("record.log"))), expected);
}

class KvaserBusTools : public BusTools {};

TEST_F(KvaserBusTools, ReplayRefusesARealInterfaceUnlessForcedAndLosesNothingInAFullQueue) {
  std::string log;
  for (int i = 0; i < 500; ++i) {
    const std::string byte{"0123456789ABCDEF"[i / 16 % 16], "0123456789ABCDEF"[i % 16]};
    log += "(1000000000.000000) can0 123#00112233445566" + byte + "\n";
  }
  write("in.log", log);
  Process refused({HYSTCAN_PROGRAM, "replay", path("in.log")});
  EXPECT_EQ(refused.wait(), 1);
  EXPECT_NE(refused.err().find("--force-interface"), std::string::npos) << refused.err();

  Process recorder = record({"--output", path("record.log")}, "can1");
  ASSERT_TRUE(recorder.says("recording can1"));
  Process replay({HYSTCAN_PROGRAM, "replay", path("in.log"), "--force-interface"});
  EXPECT_EQ(replay.wait(), 0) << replay.err();
  EXPECT_TRUE(comes_to_have("record.log", 500));
  settle();
  recorder.send(SIGINT);
  EXPECT_EQ(recorder.wait(), 0) << recorder.err();
  std::vector<std::string> sent = frames_of(log);
  for (std::string& frame : sent) frame[3] = '1';
  EXPECT_EQ(frames_of(read("record.log")), sent) << replay.err();
}

// Records on both cards at once: one card receives its own frames as an echo, the other from the wire. The
// test sends no remote frame with a length, because QEMU's card keeps bytes of it and never returns them.
TEST_F(KvaserBusTools, RecordOnBothCardsWritesWhatCandumpWritesFrameByFrame) {
  const hil::Listeners of_sender("can0"), of_receiver("can1");
  Process beside_sender = candump("candump0.log", "can0");
  Process beside_receiver = candump("candump1.log", "can1");
  Process sender = record({"--output", path("record0.log")}, "can0");
  Process receiver = record({"--output", path("record1.log")}, "can1");
  ASSERT_TRUE(sender.says("recording can0"));
  ASSERT_TRUE(receiver.says("recording can1"));
  ASSERT_TRUE(of_sender.are_more_by(2) && of_receiver.are_more_by(2));
  ASSERT_EQ(shell("cansend can0 18FEEDFE#0102030405060708 && cansend can0 123#R && cansend can0 7FF# && "
                  "cansend can1 00000001#AA && cangen can0 -g 2 -n 200 -I i -L i -D i && "
                  "cangen can1 -g 2 -n 200 -e -I i -L i -D i"),
            0);
  for (const char* log : {"candump0.log", "candump1.log", "record0.log", "record1.log"})
    EXPECT_TRUE(comes_to_have(log, 404)) << log;
  settle();
  for (Process* recorder : {&sender, &receiver}) {
    recorder->send(SIGINT);
    EXPECT_EQ(recorder->wait(), 0) << recorder->err();
    EXPECT_NE(recorder->err().find("0 frames lost"), std::string::npos) << recorder->err();
  }
  EXPECT_EQ(read("record0.log"), read("candump0.log"));
  EXPECT_EQ(read("record1.log"), read("candump1.log"));
  std::vector<std::string> received = frames_of(read("record0.log"));
  for (std::string& frame : received) frame[3] = '1';
  EXPECT_EQ(received.size(), 404U);
  EXPECT_EQ(frames_of(read("record1.log")), received) << "both cards receive the same frames";
}

/// The frames with this identifier.
std::vector<std::string> only(std::vector<std::string> frames, const std::string& id) {
  std::erase_if(frames,
                [&](const std::string& frame) { return frame.find(" " + id + "#") == std::string::npos; });
  return frames;
}

TEST_F(KvaserBusTools, RecordContinuesAfterTheInterfaceOfARunningControllerGoesDownAndUp) {
  hil::LiveBench bench({"can0", "can1"});
  // Without -D candump ends when the interface goes down.
  const hil::Listeners of_can0("can0");
  Process beside({"sh", "-c", "exec candump -D -L can0,0:0,#FFFFFFFF >" + path("candump.log")});
  Process recorder = record({"--output", path("record.log")}, "can0");
  ASSERT_TRUE(recorder.says("recording can0"));
  ASSERT_TRUE(of_can0.are_more_by(2));
  bench.start_controller({"--json"});
  ASSERT_TRUE(bench.tracks()) << bench.controller->err();
  ASSERT_EQ(shell("ip link set can0 down"), 0);
  EXPECT_TRUE(bench.controller->says("x: faulted")) << bench.controller->err();
  EXPECT_TRUE(recorder.says("can0: down; waiting for it")) << recorder.err();
  ASSERT_EQ(shell("ip link set can0 up"), 0);
  EXPECT_TRUE(bench.controller->says("can0: bus active at")) << bench.controller->err();
  settle();
  EXPECT_EQ(bench.stop_and_report(1).at("axes")[0].at("fault"), "interface down");
  EXPECT_TRUE(recorder.says("can0: up again")) << recorder.err();
  ASSERT_EQ(shell("cansend can1 555#C0FFEE"), 0);
  EXPECT_TRUE(hil::eventually([&] { return read("record.log").find(" 555#") != std::string::npos; }));
  EXPECT_TRUE(hil::eventually([&] { return read("candump.log").find(" 555#") != std::string::npos; }));
  recorder.send(SIGINT);
  EXPECT_EQ(recorder.wait(), 0) << recorder.err();
  beside.send(SIGINT);
  beside.wait();
  const std::vector<std::string> recorded = frames_of(read("record.log"));
  EXPECT_EQ(only(recorded, "555").size(), 1U) << "received after the interface is up again";
  const std::vector<std::string> by_candump = frames_of(read("candump.log"));
  const auto recorded_commands = static_cast<int>(only(recorded, "201").size());
  const auto all_commands = static_cast<int>(only(by_candump, "201").size());
  EXPECT_GT(recorded_commands, 300);
  EXPECT_LE(all_commands - recorded_commands, 60)
      << "record looks for the interface every 50 ms, so that it may miss frames";
  EXPECT_GE(all_commands, recorded_commands);
}

}  // namespace
}  // namespace hystcan::bus_tools_test
