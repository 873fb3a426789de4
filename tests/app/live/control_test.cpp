// The control socket of a running controller: every command with its answer, lines in any pieces, and the
// writer's role.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "base/error.h"
#include "tests/app/live/control_bench.h"

namespace hystcan::app::control_test {
namespace {

using controller::AxisState;
using nlohmann::json;

json command(const char* what) { return {{"do", what}}; }
json command(const char* what, const char* axis) { return {{"do", what}, {"axis", axis}}; }
json go_to(const char* axis, const json& position_um) {
  return {{"do", "go_to"}, {"axis", axis}, {"position_um", position_um}};
}

TEST(ControlSocket, ReportsTheStatusOfEveryAxisAndOfTheCycles) {
  const ControlBench bench(never_rest);
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  const json status = bench.client().ask(command("status"));
  ASSERT_TRUE(is_ok(status));
  EXPECT_GT(status.at("cycles"), 0);
  EXPECT_EQ(status.at("missed_cycles"), 0);
  ASSERT_EQ(status.at("axes").size(), 2u);
  const json& x = status.at("axes")[0];
  EXPECT_EQ(x.at("name"), "x");
  EXPECT_EQ(x.at("state"), "tracking");
  EXPECT_EQ(x.at("arrival"), "moving");
  EXPECT_EQ(x.at("live_goal"), false);
  EXPECT_DOUBLE_EQ(x.at("error_um"), x.at("reference_um").get<double>() - x.at("position_um").get<double>());
  EXPECT_EQ(status.at("axes")[1].at("name"), "y");
}

TEST(ControlSocket, ListsAllReasonsOfAWaitingAxisAndTheFirst) {
  const ControlBench bench([](const support::ShippedCopy& files) {
    // The nodes of the twin listen for an hour before they send a heartbeat.
    files.edit("piezo.toml", "heartbeat_ms = 100.0", "heartbeat_ms = 3.6e6");
    files.edit("piezo.toml", "rate_Hz = 1000.0", "rate_Hz = 1000.0\nheartbeat_timeout_ms = 7.2e6");
  });
  Client client = bench.client();
  json x;
  EXPECT_TRUE(support::eventually([&] {
    x = client.ask(command("status")).at("axes")[0];
    return x.contains("waits_for_all") && x.at("waits_for_all").size() == 2;
  })) << x;
  EXPECT_EQ(x.at("waits_for"), "a heartbeat of the sensor");
  EXPECT_EQ(x.at("waits_for_all"), (json{"a heartbeat of the sensor", "a heartbeat of the amplifier"}));
}

TEST(ControlSocket, MovesAStageToAPositionAndBackToItsReference) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  ASSERT_TRUE(is_ok(client.ask(go_to("x", 12.5))));
  const json arrived = client.ask(command("wait", "x"));
  ASSERT_TRUE(is_ok(arrived)) << arrived;
  EXPECT_NEAR(arrived.at("position_um"), 12.5, 0.05);
  EXPECT_EQ(client.ask(command("status")).at("axes")[0].at("live_goal"), true);
  ASSERT_TRUE(is_ok(client.ask(command("resume", "x"))));
  EXPECT_TRUE(support::eventually([&] {
    const json x = client.ask(command("status")).at("axes")[0];
    return x.at("live_goal") == false && x.at("reference_um") > 20.0;
  })) << "the triangle's upper end";
}

// At the second wait, the board still shows the earlier arrival. The record that answers this wait must be
// newer than the go_to.
TEST(ControlSocket, DoesNotAnswerAWaitFromAnEarlierPosition) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  for (const double position_um : {5.0, 25.0, 6.0, 24.0, 7.0, 23.0}) {
    ASSERT_TRUE(is_ok(client.ask(go_to("x", position_um))));
    const json arrived = client.ask(command("wait", "x"));
    ASSERT_TRUE(is_ok(arrived)) << arrived;
    ASSERT_NEAR(arrived.at("position_um"), position_um, 0.05);
  }
}

TEST(ControlSocket, RefusesUnreachableAndInvalidPositions) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  for (const double position_um : {-3.0, 1.0, 33.9, 1e308, -1e308})
    EXPECT_TRUE(says(client.ask(go_to("x", position_um)), "x: ")) << position_um;
  for (const json& none : {json("12.5"), json(), json(true), json::array({1.0}), json::object()})
    EXPECT_TRUE(says(client.ask(go_to("x", none)), "\"position_um\" is missing, expected a number")) << none;
  for (const char* number : {"NaN", "Infinity", "1e999"}) {
    client.send(std::string(R"({"do": "go_to", "axis": "x", "position_um": )") + number + "}\n");
    EXPECT_TRUE(says(client.read(), "expected one JSON object per line")) << number;
  }
  EXPECT_EQ(client.ask(command("status")).at("axes")[0].at("live_goal"), false) << "nothing was taken";
}

TEST(ControlSocket, SwitchesAnAxisOffAndOnAgain) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(1, AxisState::tracking));
  Client client = bench.client();
  EXPECT_TRUE(says(client.ask(command("enable", "y")), "already enabled"));
  EXPECT_EQ(client.ask(command("enable", "y")).at("refusals"), (json{{"y", "enabled_already"}}));
  EXPECT_TRUE(says(client.ask(command("clear", "y")), "no fault to clear"));
  ASSERT_TRUE(is_ok(client.ask(command("disable", "y"))));
  ASSERT_TRUE(bench.axis_is(1, AxisState::offline));
  EXPECT_EQ(bench.steps(1).back().drive, 0.0);
  EXPECT_TRUE(says(client.ask(command("disable", "y")), "not enabled"));
  EXPECT_FALSE(is_ok(client.ask(go_to("y", 10.0))));
  EXPECT_FALSE(is_ok(client.ask(command("resume", "y"))));
  ASSERT_TRUE(is_ok(client.ask(command("enable", "y"))));
  ASSERT_TRUE(bench.axis_is(1, AxisState::tracking));
  EXPECT_EQ(client.ask(command("status")).at("axes")[0].at("state"), "tracking") << "x was left alone";
}

TEST(ControlSocket, ActsOnAllAxesByDefault) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  ASSERT_TRUE(is_ok(client.ask(command("disable"))));
  ASSERT_TRUE(bench.axis_is(0, AxisState::offline));
  ASSERT_TRUE(bench.axis_is(1, AxisState::offline));
  const json refused = client.ask(command("disable"));
  EXPECT_TRUE(says(refused, "x: the axis is not enabled; y: the axis is not enabled")) << refused;
  EXPECT_TRUE(is_ok(client.ask(command("revert"))));
  EXPECT_TRUE(is_ok(client.ask(command("enable"))));
}

TEST(ControlSocket, SkipsAndNamesAxesThatNeedNoClearOrEnable) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  ASSERT_TRUE(bench.axis_is(1, AxisState::tracking));
  Client client = bench.client();
  const auto limit = [&](double um) {
    return client.ask({{"do", "set"}, {"axis", "x"}, {"key", "following_error_um"}, {"value", um}});
  };
  ASSERT_TRUE(is_ok(limit(1e-6)));
  ASSERT_TRUE(bench.axis_is(0, AxisState::faulted));
  ASSERT_TRUE(is_ok(limit(4.0)));
  EXPECT_TRUE(says(client.ask(command("enable")),
                   "x: the axis is faulted: clear the fault first; y: the axis is already enabled"));
  json cleared;
  ASSERT_TRUE(support::eventually([&] {
    cleared = client.ask(command("clear"));  // refused while the drive ramps
    return is_ok(cleared);
  })) << cleared;
  EXPECT_EQ(cleared.at("nothing_to_do"), json::array({"y: there is no fault to clear"}));
  EXPECT_TRUE(
      says(client.ask(command("clear")), "x: there is no fault to clear; y: there is no fault to clear"));
  EXPECT_EQ(client.ask(command("enable")),
            (json{{"ok", true}, {"nothing_to_do", json::array({"y: the axis is already enabled"})}}));
}

TEST(ControlSocket, StopRampsEveryAxisDownAndEndsTheRun) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  ASSERT_TRUE(is_ok(bench.client().ask(command("stop"))));
  EXPECT_TRUE(support::eventually([&] { return bench.asked_to_stop(); }));
  EXPECT_TRUE(bench.axis_is(0, AxisState::offline));
  EXPECT_TRUE(bench.axis_is(1, AxisState::offline));
}

TEST(ControlSocket, RefusesUnknownCommandsAndNamesTheExpectedOnes) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  EXPECT_TRUE(says(client.ask(command("dance")), "\"dance\" is not a command, expected status, settings"));
  EXPECT_TRUE(says(client.ask(command("enable", "z")), "there is no axis \"z\", expected x, y"));
  EXPECT_TRUE(says(client.ask(json::object()), "\"do\" is missing"));
  EXPECT_TRUE(says(client.ask({{"do", 7}}), "\"do\" is missing, expected a text"));
  EXPECT_TRUE(says(client.ask({{"do", "enable"}, {"axis", 1}}), "\"axis\" is missing, expected a text"));
  EXPECT_TRUE(says(client.ask(command("go_to", "x")), "\"position_um\" is missing"));
  EXPECT_TRUE(says(client.ask(command("set", "x")), "\"value\" is missing"));
  EXPECT_TRUE(says(client.ask({{"do", "set"}, {"axis", "x"}, {"value", 1}}), "\"key\" is missing"));
  EXPECT_TRUE(says(client.ask(command("wait")), "\"axis\" is missing"));
  for (const double timeout_s : {0.0, -1.0, 1e7})
    EXPECT_TRUE(
        says(client.ask({{"do", "wait"}, {"axis", "x"}, {"timeout_s", timeout_s}}), "expected > 0 and <="))
        << timeout_s;
}

TEST(ControlSocket, AcceptsLinesInAnyPieces) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  for (const char byte : std::string_view("{\"do\": \"status\"}\n")) client.send(std::string(1, byte));
  EXPECT_TRUE(is_ok(client.read())) << "byte by byte";
  client.send("{\"do\": \"status\"}\n{\"do\": \"dance\"}\n{\"do\": \"status\"}\r\n");
  EXPECT_TRUE(is_ok(client.read())) << "three lines at once, answered in order";
  EXPECT_TRUE(says(client.read(), "dance"));
  EXPECT_TRUE(is_ok(client.read())) << "a carriage return is white space";
  for (const char* line :
       {"", "status", "[]", "7", "null", "{", "{\"do\": \"status\"} {}", "\xff\xfe", "{\"do\"}"}) {
    client.send(std::string(line) + "\n");
    EXPECT_TRUE(says(client.read(), "expected one JSON object per line")) << line;
  }
  client.send("{\"do\": \"\xff\"}\n");
  EXPECT_FALSE(is_ok(client.read())) << "no UTF-8";
  EXPECT_TRUE(is_ok(client.ask(command("status"))));
}

TEST(ControlSocket, ClosesTheConnectionAtALineWithoutEnd) {
  const ControlBench bench;
  Client endless = bench.client();
  endless.send(std::string(70'000, ' '));
  EXPECT_TRUE(says(endless.read(), "longer than 65536 bytes"));
  EXPECT_TRUE(endless.read().is_null());
  EXPECT_FALSE(bench.client().ask(command("enable", "z")).is_null()) << "others are served";
}

// Code that recurses over a command must not exhaust the stack; otherwise a writer could crash the
// controller.
TEST(ControlSocket, SurvivesNestingAndKeysOfAnyDepth) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  client.send(R"({"do": "set", "axis": "x", "key": "kp", "value": )" + std::string(60'000, '[') + "\n");
  EXPECT_FALSE(is_ok(client.read()));
  client.send(R"({"do": "set", "axis": "x", "key": "kp", "value": )" + std::string(30'000, '[') +
              std::string(30'000, ']') + "}\n");
  EXPECT_TRUE(says(client.read(), "nested at most eight deep"));
  std::string deep = "a";
  for (int i = 0; i < 30'000; ++i) deep += ".a";
  EXPECT_TRUE(
      says(client.ask({{"do", "set"}, {"axis", "x"}, {"key", deep}, {"value", 1}}), "expected at most 200"));
}

TEST(ControlSocket, HasOneWriterUntilItDisconnects) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client looker = bench.client();
  Client writer = bench.client();
  EXPECT_TRUE(is_ok(looker.ask(command("status"))));
  ASSERT_TRUE(is_ok(writer.ask(go_to("x", 10.0)))) << "looking takes no right";
  EXPECT_TRUE(says(looker.ask(go_to("x", 20.0)), "has the right to write until it disconnects"));
  EXPECT_TRUE(says(looker.ask({{"do", "reload"}}), "right to write"));
  EXPECT_TRUE(is_ok(looker.ask(command("wait", "x"))));
  EXPECT_TRUE(is_ok(looker.ask(command("status"))));
  ASSERT_TRUE(is_ok(writer.ask(go_to("x", 11.0)))) << "it keeps it";
  writer.hang_up();
  EXPECT_TRUE(support::eventually([&] { return is_ok(looker.ask(go_to("x", 20.0))); }));
}

TEST(ControlSocket, LetsEveryConnectionDisableAndStop) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client writer = bench.client();
  ASSERT_TRUE(is_ok(writer.ask(go_to("x", 10.0))));
  Client other = bench.client();
  EXPECT_TRUE(is_ok(other.ask(command("disable", "x"))));
  EXPECT_TRUE(is_ok(other.ask(command("stop"))));
  EXPECT_TRUE(support::eventually([&] { return bench.asked_to_stop(); }));
}

TEST(ControlSocket, IsOpenToOwnerAndGroupOnly) {
  const ControlBench bench;
  struct stat file {};
  ASSERT_EQ(stat(bench.socket().c_str(), &file), 0);
  EXPECT_TRUE(S_ISSOCK(file.st_mode));
  EXPECT_EQ(file.st_mode & 0777U, 0660U);
}

TEST(ControlSocket, RefusesASecondControllerAndReplacesTheFileOfADeadOne) {
  ControlBench bench;
  boost::asio::io_context context;
  controller::RequestLink requests;
  const std::filesystem::path config = bench.files() / "piezo.toml";
  LiveConfig live(config, config::load(config));
  CycleOutlets outlets(config::load(config), {}, {});
  ControllerCommandHandler handler(context, requests, outlets, live);
  EXPECT_THROW(ControlSocket(context, bench.socket(), handler), RunError);
  EXPECT_TRUE(is_ok(bench.client().ask(command("status")))) << "the first one still listens";

  bench.end_service();
  EXPECT_FALSE(std::filesystem::exists(bench.socket()));
  {  // bound, but no longer listening
    boost::asio::local::stream_protocol::acceptor killed(context, bench.socket().string());
  }
  ASSERT_TRUE(std::filesystem::exists(bench.socket()));
  EXPECT_NO_THROW(ControlSocket(context, bench.socket(), handler));
  EXPECT_THROW(ControlSocket(context, bench.files() / "none/control.sock", handler), RunError);
}

struct UnusedSocket : testing::Test {
  ControlBench bench;
  boost::asio::io_context context;
  controller::RequestLink requests;
  CycleOutlets outlets{config::load(bench.files() / "piezo.toml"), {}, {}};
  LiveConfig live{bench.files() / "piezo.toml", config::load(bench.files() / "piezo.toml")};
  ControllerCommandHandler handler{context, requests, outlets, live};
};

TEST_F(UnusedSocket, DoesNotReplaceAFileThatIsNotASocket) {
  const std::filesystem::path file = bench.files() / "piezo.toml", link = bench.files() / "link.sock";
  const std::string before = support::read_file(file);
  EXPECT_THROW(ControlSocket(context, file, handler), RunError);
  EXPECT_EQ(support::read_file(file), before);

  std::filesystem::create_symlink(file, link);
  EXPECT_THROW(ControlSocket(context, link, handler), RunError);
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(support::read_file(file), before);
}

TEST_F(UnusedSocket, RemovesOnlyItsOwnFile) {
  const std::filesystem::path file = bench.files() / "other.sock";
  {
    const ControlSocket socket(context, file, handler);
    std::filesystem::remove(file);
    std::ofstream(file) << "of another program";
  }
  EXPECT_TRUE(std::filesystem::is_regular_file(file));
}

}  // namespace
}  // namespace hystcan::app::control_test
