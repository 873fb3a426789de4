// Sends the examples of docs/control_socket.md to a running controller in their order.
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <string>
#include <utility>

#include "tests/app/live/control_bench.h"

namespace hystcan::app::control_document_test {
namespace {

using nlohmann::json;

struct Example {
  std::string sent;
  json answer;
};

std::vector<Example> examples() {
  std::ifstream document(HYSTCAN_SOURCE_DIR "/docs/control_socket.md");
  std::vector<Example> found;
  for (std::string line; std::getline(document, line);) {
    if (line.starts_with("> {")) found.push_back({line.substr(2), {}});
    if (line.starts_with("< {")) found.back().answer = json::parse(line.substr(2));
  }
  return found;
}

std::set<std::string> keys(const json& object) {
  std::set<std::string> names;
  for (const auto& [key, value] : object.items()) names.insert(key);
  return names;
}

std::set<std::string> changes(const json& answer) {
  std::set<std::string> texts;
  for (const json& change : answer.value("changed", json::array())) texts.insert(change.dump());
  return texts;
}

// Numbers differ between runs; the document promises keys, refusals and changes.
TEST(ControlSocketDocument, GivesTheAnswersThatTheControllerSends) {
  const ControlBench bench;
  ASSERT_TRUE(bench.axis_is(0, controller::AxisState::tracking));
  Client client = bench.client();
  std::set<std::string> commands;
  for (const auto& [sent, expected] : examples()) {
    client.send(sent + "\n");
    const json answer = client.read();
    ASSERT_TRUE(answer.is_object()) << sent;
    EXPECT_EQ(keys(answer), keys(expected)) << sent << answer;
    EXPECT_EQ(answer.at("ok"), expected.at("ok")) << sent << answer;
    EXPECT_EQ(answer.value("error", ""), expected.value("error", "")) << sent;
    EXPECT_EQ(changes(answer), changes(expected)) << sent;
    const json axes = answer.value("axes", json::array());
    for (std::size_t i = 0; i < axes.size(); ++i) EXPECT_EQ(keys(axes[i]), keys(expected["axes"][i]));
    commands.insert(json::parse(sent).at("do"));
  }
  for (const ControlCommand& row : protocol::commands)
    EXPECT_EQ(commands.contains(std::string(row.word)), row.controller != Reply::none) << row.word;
}

}  // namespace
}  // namespace hystcan::app::control_document_test
