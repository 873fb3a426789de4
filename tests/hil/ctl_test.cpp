// hystcan ctl with a controller that drives the axes on vcan0: its answers, and the effect on the wire.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/hil/live_stage.h"
#include "tests/support/shows.h"

namespace hystcan::ctl_test {
namespace {

using hil::between;
using hil::Client;
using hil::json;
using hil::milliseconds;
using hil::now_s;
using hil::OnWire;
using hil::Process;
using hil::QuickStage;
using hil::series;

constexpr std::size_t x = 0;
constexpr std::size_t y = 1;

struct Ctl : testing::Test {
  QuickStage stage;

  /// Starts and waits until both axes track.
  void start() { stage.start(); }
  void expect_done(const std::vector<std::string>& words) const {
    const QuickStage::Answer answer = stage.ctl(words);
    EXPECT_EQ(answer.status, 0) << testing::PrintToString(words) << answer.err;
  }
  void expect_refused(const std::vector<std::string>& words, const std::string& reason) const {
    const QuickStage::Answer answer = stage.ctl(words);
    EXPECT_NE(answer.status, 0) << testing::PrintToString(words);
    EXPECT_NE(answer.err.find(reason), std::string::npos) << testing::PrintToString(words) << answer.err;
  }
};

TEST_F(Ctl, ReportsTheStatusOfEveryAxis) {
  start();
  for (const std::size_t axis : {x, y}) {
    const QuickStage::Answer answer = stage.ctl({"--json", "status"});
    ASSERT_EQ(answer.status, 0) << answer.err;
    const json status = json::parse(answer.out).at("axes").at(axis);
    EXPECT_EQ(status.at("state"), "tracking");
    EXPECT_EQ(status.at("fault"), "none");
    EXPECT_LT(std::abs(status.at("error_um").get<double>()), 1.0);
  }
  const QuickStage::Answer table = stage.ctl({"status"});
  EXPECT_EQ(table.status, 0);
  EXPECT_NE(table.out.find("tracking"), std::string::npos) << table.out;
}

TEST_F(Ctl, WatchShowsTheStatusAgainAndAgainUntilItIsInterrupted) {
  start();
  support::Process watch(
      {HYSTCAN_PROGRAM, "status", "--watch", "--interface", "vcan0", "--socket", stage.socket});
  for (const char* part : {"bus vcan0: up", "SYNC late", "nodes: ", "tracking"})
    EXPECT_TRUE(hil::eventually([&] { return watch.out().find(part) != std::string::npos; })) << part;
  watch.send(SIGINT);
  EXPECT_EQ(watch.wait(), 0) << watch.err();
}

TEST_F(Ctl, MovesAnAxisToAPositionWaitsForItAndResumesItsReference) {
  start();
  expect_done({"go", "x", "12.5"});
  expect_done({"wait", "x", "--timeout", "60"});
  const double arrived_s = now_s();
  std::this_thread::sleep_for(milliseconds(100));
  const double resumed_s = now_s();
  expect_refused({"go", "x", "500"}, "outside");
  expect_refused({"go", "x", "-10"}, "outside");
  expect_done({"resume", "x"});
  std::this_thread::sleep_for(milliseconds(500));
  const json log = stage.bench.decoded_with_series();
  const std::vector<OnWire> resting = between(series(log, "X", "SensorSample"), arrived_s, resumed_s);
  ASSERT_GT(resting.size(), 45u);
  for (const OnWire& sample : resting) EXPECT_NEAR(sample.value, 12.5, 0.02) << "tolerance_um";
  const std::vector<OnWire> after = between(series(log, "X", "SensorSample"), resumed_s + 0.3, now_s());
  const auto [low, high] = std::ranges::minmax(after, {}, &OnWire::value);
  EXPECT_GT(high.value - low.value, 5.0) << "x follows its triangle again";
  EXPECT_TRUE(log.at("first_fault").is_null());
}

TEST_F(Ctl, DisableRampsOneAxisDownWhileTheOtherKeepsTrackingAndEnableBringsItBack) {
  start();
  expect_refused({"clear", "x"}, "x: there is no fault to clear");
  expect_refused({"enable", "x"}, "the axis is enabled already");
  expect_done({"disable", "x"});
  ASSERT_TRUE(stage.reaches(x, "offline"));
  const double down_s = now_s();
  std::this_thread::sleep_for(milliseconds(300));
  EXPECT_EQ(stage.axis_status(y).at("state"), "tracking");
  const double enabled_s = now_s();
  expect_done({"enable", "x"});
  ASSERT_TRUE(stage.reaches(x, "tracking"));
  std::this_thread::sleep_for(milliseconds(300));

  const json log = stage.bench.decoded_with_series();
  for (const OnWire& command : between(series(log, "X", "AmpCommand"), down_s, enabled_s)) {
    EXPECT_EQ(command.byte4, 0) << "not enabled";
    EXPECT_EQ(command.value, 0.0);
  }
  const std::vector<OnWire> ramp = between(series(log, "X", "AmpCommand"), 0.0, down_s);
  EXPECT_LT(ramp.back().value, 1e-6);
  const std::vector<OnWire> other = between(series(log, "Y", "SensorSample"), down_s, enabled_s);
  const auto [low, high] = std::ranges::minmax(other, {}, &OnWire::value);
  EXPECT_GT(high.value - low.value, 1.0) << "y keeps tracking";
  EXPECT_TRUE(log.at("first_fault").is_null());
}

TEST_F(Ctl, ReportsAFaultWithItsRemedyAndTheAxisTracksAgainAfterClearAndEnable) {
  start();
  ASSERT_TRUE(hil::shell("cansend vcan0 000#0201")) << "another node stops node 1 by NMT";
  ASSERT_TRUE(stage.reaches(x, "faulted"));
  const json status = stage.axis_status(x);
  EXPECT_NE(status.at("fault"), "none");
  EXPECT_FALSE(status.at("remedy").get<std::string>().empty());
  const QuickStage::Answer table = stage.ctl({"status"});
  EXPECT_NE(table.out.find(status.at("remedy").get<std::string>()), std::string::npos) << table.out;
  std::printf("x: %s; %s\n", status.at("fault").get<std::string>().c_str(),
              status.at("remedy").get<std::string>().c_str());
  expect_refused({"enable", "x"}, "clear the fault first");
  expect_refused({"wait", "x"}, "faulted");
  expect_done({"clear", "x"});
  ASSERT_TRUE(stage.reaches(x, "offline"));
  expect_done({"enable", "x"});
  ASSERT_TRUE(stage.reaches(x, "tracking")) << stage.bench.controller->err();
  EXPECT_EQ(stage.axis_status(y).at("state"), "tracking");
  expect_done({"stop"});
  EXPECT_EQ(stage.bench.controller->wait(), 0) << "a cleared fault does not change the exit status";
}

TEST_F(Ctl, StopEndsTheControllerCleanly) {
  shows("S-060");
  start();
  expect_done({"stop"});
  EXPECT_EQ(stage.bench.controller->wait(), 0) << stage.bench.controller->err();
  EXPECT_FALSE(std::filesystem::exists(stage.socket)) << "the socket is removed";
  const json log = stage.log_at_rest();
  hil::expect_both_safe(log);
  EXPECT_EQ(log.at("last_command").at("enable"), 0);
  EXPECT_NEAR(log.at("last_enabled_command").at("setpoint"), 0.0, 4.1) << "one cycle of 2000 V/s";
}

TEST_F(Ctl, AllowsOneWriterAtATimeAndAnyClientToReadAndStop) {
  start();
  {
    const Client writer(stage.socket);
    EXPECT_TRUE(
        writer.says("{\"do\": \"go_to\", \"axis\": \"x\", \"position_um\": 15.0}\n").value("ok", false));
    expect_refused({"resume", "x"}, "has the right to write until it disconnects");
    expect_refused({"set", "x", "kp", "0.04"}, std::to_string(getpid()));
    expect_done({"status"});
    expect_done({"wait", "x", "--timeout", "60"});
  }
  expect_done({"resume", "x"});
  const Client writer(stage.socket);
  EXPECT_TRUE(writer.says("{\"do\": \"resume\", \"axis\": \"x\"}\n").value("ok", false));
  expect_done({"stop"});
  EXPECT_EQ(stage.bench.controller->wait(), 0) << stage.bench.controller->err();
}

TEST_F(Ctl, AnswersGarbageWithAnErrorAndTheControllerKeepsTracking) {
  start();
  const Client line(stage.socket);
  for (const std::string garbage :
       {"\n", "hello\n", "[1, 2]\n", "{\n", "{\"do\": 7}\n", "{\"do\": \"fly\"}\n", "{\"do\": \"go_to\"}\n",
        "{\"do\": \"go_to\", \"axis\": \"z\", \"position_um\": 1}\n", "{\"do\": \"wait\", \"axis\": 1}\n",
        "{\"do\": \"go_to\", \"axis\": \"x\", \"position_um\": \"far\"}\n", "\xff\xfe\x01\n",
        "{\"do\": \"set\", \"axis\": \"x\", \"key\": \"kp\", \"value\": -1}\n",
        "{\"do\": \"set\", \"axis\": \"x\", \"key\": \"\\u0000]\", \"value\": []}\n"}) {
    const json answer = line.says(garbage);
    ASSERT_TRUE(answer.is_object()) << garbage;
    EXPECT_FALSE(answer.value("ok", true)) << garbage << answer;
    EXPECT_FALSE(answer.value("error", "").empty()) << garbage;
  }
  const json too_long = Client(stage.socket).says(std::string(70'000, 'a'));
  EXPECT_NE(too_long.value("error", "").find("longer than"), std::string::npos) << too_long;
  EXPECT_EQ(stage.axis_status(x).at("state"), "tracking");
  EXPECT_TRUE(stage.bench.controller->running());
}

TEST_F(Ctl, SocketIsOpenToOwnerAndGroupAndAStaleSocketIsReplaced) {
  start();
  struct stat found {};
  ASSERT_EQ(stat(stage.socket.c_str(), &found), 0);
  EXPECT_TRUE(S_ISSOCK(found.st_mode));
  EXPECT_EQ(found.st_mode & 0777U, 0660U);
  stage.bench.controller->send(SIGKILL);
  EXPECT_EQ(stage.bench.controller->wait(), 128 + SIGKILL);
  ASSERT_TRUE(std::filesystem::exists(stage.socket)) << "the killed controller leaves its socket";
  expect_refused({"status"}, "is the controller running");
  stage.start({"--clear-faults"});
  EXPECT_EQ(stage.axis_status(x).at("state"), "tracking");
}

TEST_F(Ctl, ASecondControllerOnTheSameSocketIsRefusedAndTheFirstKeepsTracking) {
  start();
  Process second({HYSTCAN_PROGRAM, "controller", stage.config, "--interface", "vcan0"});
  EXPECT_EQ(second.wait(), 1);
  EXPECT_NE(second.err().find("another process listens there"), std::string::npos) << second.err();
  EXPECT_EQ(stage.axis_status(x).at("state"), "tracking");
  EXPECT_EQ(stage.axis_status(y).at("state"), "tracking");
}

TEST_F(Ctl, StopGetsThroughMoreIdleConnectionsThanTheControllerMayHaveFiles) {
  start();
  constexpr rlim_t enough = 1300;
  const rlimit more{.rlim_cur = enough, .rlim_max = std::max<rlim_t>(enough, 4096)};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &more), 0) << "of this process, after the start of the controller";
  std::vector<std::unique_ptr<Client>> idle;
  for (int i = 0; i < 1100; ++i) idle.push_back(std::make_unique<Client>(stage.socket));
  EXPECT_EQ(stage.axis_status(x).at("state"), "tracking");
  expect_done({"stop"});
  EXPECT_EQ(stage.bench.controller->wait(), 0) << stage.bench.controller->err();
}

TEST_F(Ctl, FindsTheSocketOfItsInterfaceInTheRuntimeDirectory) {
  setenv("XDG_RUNTIME_DIR", stage.folder().c_str(), 1);
  stage.files.edit("piezo.toml", "control_socket = \"" + stage.socket + "\"\n", "");
  stage.start();
  EXPECT_TRUE(std::filesystem::exists(stage.folder() + "/hystcan-vcan0.sock"));
  Process status({HYSTCAN_PROGRAM, "ctl", "status"});
  EXPECT_EQ(status.wait(), 0) << status.err();
  unsetenv("XDG_RUNTIME_DIR");
}

}  // namespace
}  // namespace hystcan::ctl_test
