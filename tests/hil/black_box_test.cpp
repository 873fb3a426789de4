// After a fault on vcan0 a file holds the cycles before the fault and those after it.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/hil/live_stage.h"

namespace hystcan::black_box_test {
namespace {

using hil::json;
using hil::LiveStage;
using hil::milliseconds;

/// The rows of a CSV, header first, without the lines that begin with #.
std::vector<std::vector<std::string>> rows_of(const std::filesystem::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

std::vector<std::filesystem::path> black_boxes(const std::string& folder, const std::string& axis) {
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (name.starts_with("blackbox_") && name.ends_with("_" + axis + ".csv")) found.push_back(entry.path());
  }
  return found;
}

TEST(BlackBox, HoldsTheCyclesBeforeAFaultTheFaultAndAHundredAfterIt) {
  LiveStage stage;
  stage.start();
  ASSERT_TRUE(hil::shell("cansend vcan0 000#0201"))
      << "an NMT stop from another node stops the amplifier of x";
  ASSERT_TRUE(stage.bench.controller->says("x: the last ")) << stage.bench.controller->err();
  EXPECT_EQ(stage.axis_status(1).at("state"), "tracking") << "the fault does not concern y";

  const auto files = black_boxes(stage.folder(), "x");
  ASSERT_EQ(files.size(), 1u);
  EXPECT_TRUE(black_boxes(stage.folder(), "y").empty());
  const auto rows = rows_of(files.front());
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(rows.front(), name) - rows.front().begin());
  };
  const std::size_t cycle = column("cycle");
  const std::size_t state = column("state");
  ASSERT_LT(std::max(cycle, state), rows.front().size());
  std::size_t fault_row = 0;
  for (std::size_t i = 1; i < rows.size() && fault_row == 0; ++i)
    if (rows[i].at(state) == "faulted") fault_row = i;
  ASSERT_GT(fault_row, 250u) << "start-up and tracking come before it";
  EXPECT_EQ(rows.at(fault_row - 1).at(state), "tracking");
  EXPECT_EQ(rows.size() - 1 - fault_row, 100u);
  for (std::size_t i = fault_row - 100; i + 1 < rows.size(); ++i)
    EXPECT_EQ(std::stoul(rows[i + 1].at(cycle)), std::stoul(rows[i].at(cycle)) + 1);
}

}  // namespace
}  // namespace hystcan::black_box_test
