// The pages of docs/troubleshooting/: the commands under "With the twin" run as written, and the log contains
// the quoted lines. tests/documents/symptoms_test compares the pictures of these runs.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "can/bus_health_log.h"
#include "controller/control/fault.h"
#include "tests/support/process.h"

namespace hystcan::documents::symptom_test {
namespace {

namespace fs = std::filesystem;

const fs::path documents = HYSTCAN_SOURCE_DIR "/docs";

std::string page_of(const std::string& name) {
  return support::read_file(documents / "troubleshooting" / (name + ".md"));
}

/// Returns the first block under a heading, or an empty text.
std::string block_under(const std::string& page, const std::string& heading) {
  const auto section = page.find("\n## " + heading + "\n");
  if (section == std::string::npos) return {};
  const std::string text = page.substr(section + 1, page.find("\n## ", section + 1) - section);
  const auto fence = text.find("\n```");
  if (fence == std::string::npos) return {};
  const auto begin = text.find('\n', fence + 1) + 1;
  return text.substr(begin, text.find("\n```", begin) + 1 - begin);
}

/// Returns the output of the commands of a page on both streams, in a folder with the shipped configurations.
std::string printed_by(const std::string& name) {
  const support::ScratchFolder folder;
  for (const auto& entry : fs::directory_iterator(HYSTCAN_SOURCE_DIR "/config"))
    if (entry.path().extension() == ".toml" || entry.path().extension() == ".dbc")
      fs::copy_file(entry.path(), folder / entry.path().filename().string());
  const std::string program_folder = fs::path(HYSTCAN_PROGRAM).parent_path().string();
  support::Process bash({"bash", "-c",
                         fmt::format("cd '{}' && PATH='{}':$PATH && exec 2>&1\n{}", folder.path().string(),
                                     program_folder, block_under(page_of(name), "With the twin"))});
  bash.wait();  // a run with a fault ends with status 1
  return bash.out() + bash.err();
}

std::string without_breaks(const std::string& text) {
  return std::regex_replace(text, std::regex("\\s+"), " ");
}

std::vector<std::string> all_pages() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(documents / "troubleshooting"))
    names.push_back(entry.path().stem().string());
  std::ranges::sort(names);
  return names;
}

class Symptom : public testing::TestWithParam<std::string> {};

// A line of the log that is longer than the page continues after an indent.
TEST_P(Symptom, QuotesTheOutputOfItsRunInOrder) {
  const std::string page = page_of(GetParam());
  const std::string quoted =
      std::regex_replace(block_under(page, "What the log says"), std::regex("\n +"), " ");
  if (block_under(page, "With the twin").empty()) return;  // needs a bus, or a browser
  const std::string printed = without_breaks(printed_by(GetParam()));
  std::istringstream lines(quoted);
  std::string line;
  std::size_t from = 0;
  while (std::getline(lines, line)) {
    const auto at = printed.find(without_breaks(line), from);
    ASSERT_NE(at, std::string::npos) << line << "\nis not in\n" << printed;
    from = at;
  }
}

TEST_P(Symptom, IsInTheIndexAndHasItsPictureOnAPageOfAtMost120Lines) {
  const std::string page = page_of(GetParam());
  EXPECT_NE(
      support::read_file(documents / "troubleshooting.md").find("](troubleshooting/" + GetParam() + ".md)"),
      std::string::npos);
  EXPECT_LE(std::ranges::count(page, '\n'), 120);
  const bool has_picture = fs::exists(documents / "figures/symptoms" / (GetParam() + ".svg"));
  EXPECT_EQ(page.find("](../figures/symptoms/" + GetParam() + ".svg)") != std::string::npos, has_picture);
}

INSTANTIATE_TEST_SUITE_P(, Symptom, testing::ValuesIn(all_pages()), [](const auto& test) {
  return std::regex_replace(test.param, std::regex("-"), "_");
});

// No simulated bus can produce the bus-off of this computer, so the lines are taken from the code that writes
// them.
TEST(SymptomPages, QuoteTheLinesOfABusOff) {
  std::string lines;
  can::BusHealthLog log("can0", [&](auto, const std::string& line) { lines += line + "\n"; });
  can::BusReport report;
  report.time_s = 0.5;
  report.state = can::BusState::passive;
  report.error_counters = can::ErrorCounters{.transmit = 128, .receive = 3};
  log.sample(report);
  log.sample(
      {.time_s = 0.6, .state = can::BusState::bus_off, .refusal = {}, .error_counters = {}, .counters = {}});
  log.write();
  lines += fmt::format("x: faulted at 0.600 s: {}; {}\n", to_string(controller::Cause::bus_off),
                       remedy(controller::Cause::bus_off));
  EXPECT_EQ(block_under(page_of("bus-off"), "What the log says"), lines);
}

TEST(SymptomPages, QuoteTheTextsOfTheBrowserWithoutAController) {
  const fs::path web = HYSTCAN_SOURCE_DIR "/app/page/web";
  for (const auto& [words, file] : {std::pair{"connected, no controller", "main.js"},
                                    std::pair{"no answer from the controller", "status_view.js"}}) {
    EXPECT_NE(support::read_file(documents / "troubleshooting.md").find(words), std::string::npos) << words;
    EXPECT_NE(support::read_file(web / file).find(words), std::string::npos) << words;
  }
}

}  // namespace
}  // namespace hystcan::documents::symptom_test
