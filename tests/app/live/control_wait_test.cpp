// The ends of a wait over the control socket.
#include <gtest/gtest.h>

#include "tests/app/live/control_bench.h"

namespace hystcan::app::control_wait_test {
namespace {

using controller::AxisState;
using nlohmann::json;

const json wait_for_x{{"do", "wait"}, {"axis", "x"}};
json command(const char* what) { return {{"do", what}, {"axis", "x"}}; }
json go_to(double position_um) { return {{"do", "go_to"}, {"axis", "x"}, {"position_um", position_um}}; }
json set(const char* key, double value) {
  return {{"do", "set"}, {"axis", "x"}, {"key", key}, {"value", value}};
}

TEST(Wait, FailsIfTheStageDoesNotArriveInTime) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  ASSERT_TRUE(is_ok(client.ask(set("in_position.tolerance_um", 1e-9)))) << "far within the noise";
  ASSERT_TRUE(is_ok(client.ask(go_to(12.0))));
  EXPECT_TRUE(says(client.ask(wait_for_x), "not in position within timeout_ms"));
}

TEST(Wait, EndsWhenAnotherClientDisablesTheAxis) {
  const ControlBench bench(never_rest);
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client waiting = bench.client();
  Client other = bench.client();
  waiting.send(wait_for_x.dump() + "\n");
  ASSERT_TRUE(is_ok(other.ask(command("disable"))));
  EXPECT_TRUE(says(waiting.read(), "the axis was stopped"));
}

TEST(Wait, EndsWithAFaultAndSucceedsAfterClearAndEnable) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  ASSERT_TRUE(is_ok(client.ask(set("following_error_um", 1e-6))));
  EXPECT_TRUE(says(client.ask(wait_for_x), "faulted: following error"));
  const json x = client.ask({{"do", "status"}}).at("axes")[0];
  EXPECT_EQ(x.at("state"), "faulted");
  EXPECT_EQ(x.at("fault"), "following error");
  EXPECT_GT(x.at("fault_time_s"), 0.0);
  EXPECT_FALSE(x.at("remedy").get<std::string>().empty());
  EXPECT_TRUE(says(client.ask(command("enable")), "clear the fault first"));
  ASSERT_TRUE(is_ok(client.ask(set("following_error_um", 4.0))));
  ASSERT_TRUE(support::eventually([&] { return is_ok(client.ask(command("clear"))); }))
      << "refused while the drive ramps";
  EXPECT_TRUE(says(client.ask(command("clear")), "no fault to clear"));
  ASSERT_TRUE(is_ok(client.ask(command("enable"))));
  EXPECT_TRUE(bench.axis_is(0, AxisState::tracking));
}

// The board still shows earlier records of the axis: offline, faulted. None of these may answer the wait.
TEST(Wait, AfterEnableLastsUntilTheAxisHasStarted) {
  const ControlBench bench([](const support::ShippedCopy& files) {
    files.edit("piezo.toml",
               "kind         = \"triangle\"\nlow_um       = 3.0\nhigh_um      = 27.0\nfrequency_Hz = "
               "10.0\ncycles       = 10.0",
               "kind         = \"hold\"\nlevel_um     = 15.0\nduration_s   = 3600.0");
  });
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(is_ok(client.ask(command("disable"))));
    ASSERT_TRUE(bench.axis_is(0, AxisState::offline));
    ASSERT_TRUE(is_ok(client.ask(command("enable"))));
    const json arrived = client.ask(wait_for_x);
    ASSERT_TRUE(is_ok(arrived)) << arrived;
    EXPECT_NEAR(arrived.at("position_um"), 15.0, 0.05);
  }
}

TEST(Wait, EndsWithItsOwnTimeout) {
  const ControlBench bench(never_rest);
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  json wait = wait_for_x;
  wait["timeout_s"] = 0.02;
  EXPECT_TRUE(says(bench.client().ask(wait), "timed out: not in position within timeout_s"));
}

void without_in_position(const support::ShippedCopy& files) {
  const std::string text = support::read_file(files / "piezo.toml");
  const std::size_t from = text.find("[axis.control.in_position]");
  files.edit("piezo.toml", text.substr(from, text.find("[[axis.control.setpoint]]") - from), "");
}

TEST(Wait, NeedsAnAxisWithInPosition) {
  const ControlBench bench(without_in_position);
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  EXPECT_TRUE(says(bench.client().ask(wait_for_x), "no [axis.control.in_position]"));
}

TEST(Wait, ReleasesTheWriterRoleIfItsClientIsKilled) {
  const ControlBench bench(never_rest);
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client killed = bench.client();
  ASSERT_TRUE(is_ok(killed.ask(set("kp", 0.06))));
  killed.send(wait_for_x.dump() + "\n");  // without an end
  killed.hang_up();
  Client next = bench.client();
  EXPECT_TRUE(support::eventually([&] { return is_ok(next.ask(set("kp", 0.07))); }));
}

TEST(Wait, ContinuesIfTheClientClosesOnlyItsSendingSide) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  ASSERT_TRUE(is_ok(client.ask(go_to(12.0))));
  client.send(wait_for_x.dump() + "\n");
  client.end_sending();  // as `nc -N` does
  EXPECT_TRUE(is_ok(client.read()));
}

TEST(Wait, IsAnsweredWhenTheControllerEnds) {
  ControlBench bench(never_rest);
  ASSERT_TRUE(bench.axis_is(0, AxisState::tracking));
  Client client = bench.client();
  Client other = bench.client();
  client.send(wait_for_x.dump() + "\n");
  ASSERT_TRUE(is_ok(other.ask({{"do", "status"}}))) << "the line before has been read then";
  bench.end_service();
  EXPECT_TRUE(says(client.read(), "the controller is ending"));
  EXPECT_TRUE(client.read().is_null());
}

}  // namespace
}  // namespace hystcan::app::control_wait_test
