// The setup of a new actuator on real SocketCAN (docs/new_actuator.md): excite, identify, check, controller.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "config/files/dataset_file.h"
#include "tests/hil/live_bench.h"
#include "tests/support/shipped.h"

namespace hystcan::excite_test {
namespace {

using hil::config_file;
using hil::json;
using hil::LiveBench;
using hil::milliseconds;
using hil::Process;
using identification::Dataset;

/// A program of some seconds: one major loop, a nested one, a reversal curve in each direction. Its size is
/// stated, so no smaller loops run first: bench and rehearsal begin with the same memory.
const std::vector<std::string> short_program{"--low", "0",        "--high", "100",      "--period",
                                             "1",     "--cycles", "1",      "--levels", "1"};
constexpr double slew_V_per_s = 200.0;

std::filesystem::path in_scratch(const char* name) {
  return std::filesystem::path(testing::TempDir()) / name;
}

/// Returns the dataset that `excite` measures on the bus.
Dataset excited(LiveBench& bench, std::vector<std::string> options) {
  const auto file = in_scratch("excited.csv");
  options.insert(options.end(), {"--overwrite", "--output", file.string()});
  bench.start("excite", options);
  EXPECT_EQ(bench.controller->wait(), 0) << bench.controller->err();
  return config::load_dataset(file).dataset;
}

Dataset rehearsed(std::vector<std::string> options) {
  const auto file = in_scratch("rehearsed.csv");
  options.insert(options.begin(), {HYSTCAN_PROGRAM, "excite", config_file, "--rehearse", "--overwrite",
                                   "--output", file.string()});
  Process program(options);
  EXPECT_EQ(program.wait(), 0) << program.err();
  return config::load_dataset(file).dataset;
}

/// The largest differences between rows with the same time, to the nearest cycle.
struct Difference {
  double input = 0.0;
  double output = 0.0;
  std::size_t rows = 0;
};
Difference difference(const Dataset& dataset, const Dataset& expected) {
  Difference d;
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    const auto n = static_cast<std::size_t>(std::llround(dataset.time_s[i] * 1e3));
    if (n >= expected.size()) continue;
    d.input = std::max(d.input, std::abs(dataset.input[i] - expected.input[n]));
    d.output = std::max(d.output, std::abs(dataset.output[i] - expected.output[n]));
    ++d.rows;
  }
  return d;
}

// A SYNC is sent some microseconds late. 50 us at 200 V/s are 10 mV. At the steepest part of the curves, 0.4
// um/V, and with a resonance that doubles it, this becomes 8 nm. The noise of two datasets, 0.3 nm each, adds
// 2.5 nm at six standard deviations.
TEST(Icount, ExciteMeasuresTheSameDatasetAsItsRehearsalToNanometres) {
  const Dataset expected = rehearsed(short_program);
  LiveBench bench({"vcan0", "vcan0"});
  // At equal priority, a SYNC waits up to 100 us for heartbeats of the twin, which then become due.
  bench.controller_priority = hil::priority_over_nodes;
  const Dataset dataset = excited(bench, short_program);
  EXPECT_NEAR(static_cast<double>(dataset.size()), static_cast<double>(expected.size()), 1.0)
      << "the last cycle may fall on either side of the end";
  const Difference d = difference(dataset, expected);
  std::printf("excite: %zu rows on vcan0, %zu rehearsed; greatest difference %.6f V, %.6f um\n",
              dataset.size(), expected.size(), d.input, d.output);
  EXPECT_LT(d.input, 0.010);
  EXPECT_LT(d.output, 0.0105);

  std::this_thread::sleep_for(milliseconds(100));
  const json log = bench.decoded();
  EXPECT_TRUE(log.at("wrong").empty()) << log.at("wrong");
  EXPECT_NEAR(log.at("drive_range")[0], 0.0, 1e-6) << "drive_min_V, to the resolution of Setpoint";
  EXPECT_NEAR(log.at("drive_range")[1], 100.0, 1e-6) << "drive_max_V";
  EXPECT_EQ(log.at("last_command").at("enable"), 0);
  EXPECT_EQ(log.at("last_command").at("setpoint"), 0.0);
  EXPECT_EQ(log.at("seen").value("YAmpCommand", 0), 0) << "the other axis is not driven";
  EXPECT_FALSE(log.at("seen").contains("XAmpEmcy"));
}

TEST(Vcan, ControlCOnExciteRampsDownAndKeepsTheRows) {
  LiveBench bench({"vcan0", "vcan0"});
  const auto file = in_scratch("stopped.csv");
  bench.start("excite", {"--overwrite", "--output", file.string(), "--low", "20"});
  ASSERT_TRUE(bench.controller->says("x: tracking")) << bench.controller->err();
  std::this_thread::sleep_for(milliseconds(500));
  bench.controller->send(SIGINT);
  EXPECT_EQ(bench.controller->wait(), 1);
  EXPECT_NE(bench.controller->err().find("stopped after"), std::string::npos) << bench.controller->err();
  EXPECT_GT(config::load_dataset(file).dataset.size(), 100u);
  std::this_thread::sleep_for(milliseconds(100));
  hil::expect_stopped_by_a_ramp(bench.decoded());
}

}  // namespace
}  // namespace hystcan::excite_test
