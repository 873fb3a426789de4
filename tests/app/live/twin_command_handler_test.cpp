// The twin's side of its control socket: the examples of docs/twin.md, the refused commands, and one
// conversation over a real socket. The twin runs in virtual time, which each test advances.
#include "app/live/twin_command_handler.h"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "app/live/control_socket.h"
#include "app/live/socket_place.h"
#include "can/sim/sim_bus.h"
#include "config/schema/config.h"
#include "tests/app/live/control_bench.h"

namespace hystcan::app::twin_command_handler_test {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

class TwinCommandHandlerTest : public testing::Test {
 protected:
  TwinCommandHandlerTest() {
    twin.start();
    run_for(milliseconds(500));
  }
  void run_for(can::Duration time) { clock.run_until(clock.now() + time); }
  json ask(const json& command) {
    json received;
    int answers = 0;
    handler.execute(command, {[&](json answer) {
                      received = std::move(answer);
                      ++answers;
                    }});
    EXPECT_EQ(answers, 1) << command;
    return received;
  }
  void expect_refused(const json& command, const std::string& reason) {
    const json answer = ask(command);
    EXPECT_EQ(answer.at("ok"), false) << command;
    EXPECT_NE(answer.value("error", "").find(reason), std::string::npos) << answer;
  }

  config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  can::VirtualClock clock;
  can::SimBus bus{clock, {}};
  std::unique_ptr<can::Bus> second_node = bus.attach();  // acknowledges the frames of the twin
  twin::Twin twin{twin_config(config), config.database, clock, [this](auto) { return bus.attach(); }};
  bool stopped = false;
  TwinCommandHandler handler{twin, clock, [this] { stopped = true; }};
};

std::set<std::string> keys(const json& object) {
  std::set<std::string> names;
  for (const auto& [key, value] : object.items()) names.insert(key);
  return names;
}

// Numbers differ between runs; the document promises keys and texts.
TEST_F(TwinCommandHandlerTest, GivesTheAnswersOfTheDocument) {
  std::ifstream document(HYSTCAN_SOURCE_DIR "/docs/twin.md");
  std::set<std::string> commands;
  json answer;
  for (std::string line; std::getline(document, line);) {
    if (line.starts_with("> {")) {
      const json command = json::parse(line.substr(2));
      answer = ask(command);
      commands.insert(command.at("do"));
    } else if (line.starts_with("< {")) {
      const json expected = json::parse(line.substr(2));
      EXPECT_EQ(keys(answer), keys(expected)) << answer;
      for (const char* text : {"ok", "error", "fault", "removed"})
        EXPECT_EQ(answer.value(text, json()), expected.value(text, json())) << answer;
      for (const char* list : {"axes", "faults"}) {
        const json actual = answer.value(list, json::array());
        const json documented = expected.value(list, json::array());
        ASSERT_EQ(actual.size(), documented.size()) << answer;
        for (std::size_t i = 0; i < actual.size(); ++i)
          EXPECT_EQ(keys(actual[i]), keys(documented[i])) << answer;
      }
    }
  }
  for (const ControlCommand& row : protocol::commands)
    EXPECT_EQ(commands.contains(std::string(row.word)), row.twin != Reply::none) << row.word;
  EXPECT_TRUE(stopped);
}

TEST_F(TwinCommandHandlerTest, InjectsAFaultThatEndsAfterItsDuration) {
  EXPECT_TRUE(is_ok(
      ask({{"do", "inject"}, {"kind", "load_step"}, {"axis", "y"}, {"value", 2.0}, {"duration_s", 0.5}})));
  run_for(milliseconds(400));
  const json status = ask({{"do", "status"}});
  EXPECT_NEAR(status.at("axes")[1].at("position_um").get<double>() -
                  status.at("axes")[0].at("position_um").get<double>(),
              2.0, 0.01)
      << "the resonance still rings a little";
  EXPECT_EQ(status.at("faults")[0].at("kind"), "load_step");
  run_for(milliseconds(200));
  EXPECT_TRUE(ask({{"do", "status"}}).at("faults").empty());
}

TEST_F(TwinCommandHandlerTest, RemovesFaultsAndReturnsTheirNumberAsRemoved) {
  ask({{"do", "inject"}, {"kind", "late"}, {"axis", "x"}});
  ask({{"do", "inject"}, {"kind", "late"}, {"axis", "y"}});
  ask({{"do", "inject"}, {"kind", "load_step"}, {"axis", "y"}});
  EXPECT_EQ(ask({{"do", "remove"}, {"kind", "late"}, {"axis", "y"}}), (json{{"ok", true}, {"removed", 1}}));
  EXPECT_EQ(ask({{"do", "status"}}).at("faults").size(), 2u);
  EXPECT_EQ(ask({{"do", "remove"}}), (json{{"ok", true}, {"removed", 2}}));
  EXPECT_TRUE(ask({{"do", "status"}}).at("faults").empty());
}

TEST_F(TwinCommandHandlerTest, RefusesAnInvalidCommandAndChangesNothing) {
  expect_refused({{"do", "heal"}}, "\"heal\" is not a command, expected status, inject, remove or stop");
  expect_refused({{"do", "dance"}}, "expected status, inject, remove or stop");
  expect_refused(json::object(), "\"do\" is missing");
  expect_refused({{"do", "inject"}, {"axis", "x"}}, "\"kind\" is missing");
  expect_refused({{"do", "inject"}, {"kind", "late"}}, "\"axis\" is missing");
  expect_refused({{"do", "inject"}, {"kind", "lat"}, {"axis", "x"}},
                 "there is no fault \"lat\", expected one of");
  expect_refused({{"do", "inject"}, {"kind", "late"}, {"axis", "z"}}, "there is no axis \"z\"");
  expect_refused({{"do", "inject"}, {"kind", "late"}, {"axis", "x"}, {"node", "gate"}},
                 "expected sensor or amplifier");
  expect_refused({{"do", "inject"}, {"kind", "late"}, {"axis", "x"}, {"value", 99}}, "expected 1 to 16");
  expect_refused({{"do", "inject"}, {"kind", "late"}, {"axis", "x"}, {"value", "many"}}, "expected a number");
  expect_refused({{"do", "inject"}, {"kind", "duplicate"}, {"axis", "x"}, {"value", 1}},
                 "a value is not allowed");
  expect_refused({{"do", "inject"}, {"kind", "late"}, {"axis", "x"}, {"duration_s", -1}},
                 "expected more than 0");
  expect_refused({{"do", "inject"}, {"kind", "late"}, {"axis", "x"}, {"duration_s", 1e300}}, "up to 1e+06");
  expect_refused({{"do", "remove"}, {"kind", 7}}, "\"kind\" is missing, expected a text");
  EXPECT_TRUE(ask({{"do", "status"}}).at("faults").empty());
}

/// Twin, handler and socket run on one thread, as in the program; the clients run on another.
TEST_F(TwinCommandHandlerTest, AllowsOneWriterAtATimeOnItsSocket) {
  const support::ShippedCopy files;
  boost::asio::io_context context{1};
  const ControlSocket socket(context, files / "twin.sock", handler);
  std::thread clients([&] {
    Client writer(files / "twin.sock");
    EXPECT_TRUE(is_ok(writer.ask({{"do", "inject"}, {"kind", "no_reply"}, {"axis", "x"}})));
    Client other(files / "twin.sock");
    EXPECT_TRUE(
        says(other.ask({{"do", "inject"}, {"kind", "late"}, {"axis", "x"}}), "has the right to write"));
    EXPECT_EQ(other.ask({{"do", "status"}}).at("faults").size(), 1u);
    EXPECT_EQ(other.ask({{"do", "remove"}}).at("removed"), 1);
    context.stop();
  });
  context.run();
  clients.join();
}

TEST(TwinSocket, HasAnotherDefaultNameThanTheSocketOfTheController) {
  EXPECT_EQ(default_twin_socket("vcan0").filename(), "hystcan-twin-vcan0.sock");
  EXPECT_NE(default_twin_socket("vcan0"), default_socket("vcan0"));
}

}  // namespace
}  // namespace hystcan::app::twin_command_handler_test
