// A configuration file that was made to stop the controller: it is refused, and the controller goes on.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <boost/asio/post.hpp>
#include <fstream>
#include <new>

#include "tests/app/live/control_bench.h"

namespace hystcan::app::hostile_reload_test {
namespace {

using controller::AxisState;
using nlohmann::json;

const json reload{{"do", "reload"}};

struct HostileReload : testing::Test {
  ControlBench bench;
  Client client = bench.client();
  std::filesystem::path file = bench.files() / "piezo.toml";

  void SetUp() override { ASSERT_TRUE(bench.axis_is(0, AxisState::tracking)); }
  /// Puts `text` in the place of the configuration, in one step.
  void replace_by(const std::string& text) const {
    std::ofstream(bench.files() / "draft", std::ios::binary) << text;
    std::filesystem::rename(bench.files() / "draft", file);
  }
  void expect_refused(const char* reason) {
    const json answer = client.ask(reload);
    EXPECT_TRUE(says(answer, reason)) << answer;
    EXPECT_TRUE(says(answer, file.string())) << answer;
    EXPECT_EQ(client.ask({{"do", "status"}}).at("axes")[0].at("state"), "tracking");
  }
};

TEST_F(HostileReload, OfADeepKeyIsRefusedAndTheAxisKeepsTracking) {
  std::string deep = "a";
  for (int i = 0; i < 60'000; ++i) deep += ".a";
  replace_by(deep + " = 1\n");
  expect_refused(":1:32: a key of more than 16 parts, expected TOML");
}

TEST_F(HostileReload, OfACharacterOutsideAsciiInAKeyIsRefusedAndTheAxisKeepsTracking) {
  replace_by("\xC2\xB5 = 1\n");
  expect_refused(":1:1: a character outside ASCII that is not in a string, expected TOML");
}

TEST_F(HostileReload, OfAPipeIsRefusedAndStatusAndStopAreAnswered) {
  std::filesystem::remove(file);
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  expect_refused("it is a pipe or a device, expected a TOML file");
  ASSERT_TRUE(is_ok(client.ask({{"do", "stop"}})));
  EXPECT_TRUE(support::eventually([&] { return bench.asked_to_stop(); }));
  bench.end_service();
}

TEST(ControlServiceThread, GoesOnAfterAHandlerThatThrows) {
  boost::asio::io_context context;
  bool reached = false;
  boost::asio::post(context, [] { throw std::bad_alloc(); });
  boost::asio::post(context, [] { throw 7; });
  boost::asio::post(context, [&] {
    reached = true;
    context.stop();
  });
  run_despite_exceptions(context);
  EXPECT_TRUE(reached);
}

}  // namespace
}  // namespace hystcan::app::hostile_reload_test
