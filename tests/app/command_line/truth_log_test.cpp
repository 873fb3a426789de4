#include "app/command_line/truth_log.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "tests/support/scratch.h"

namespace hystcan::app::truth_log_test {
namespace {

const twin::Truth truth{.time = can::Time(std::chrono::milliseconds(1500)),
                        .axis = 1,
                        .sync_counter = 7,
                        .setpoint = 50.25,
                        .drive = 50.125,
                        .hysteresis_um = 15.5,
                        .position_um = 15.25,
                        .measured_um = 15.2503};

TEST(TruthLog, HasARowForEachSampleOfAnAxis) {
  const auto file = support::scratch_file("truth.csv");
  TruthLog log(file, {"x", "y"});
  log.write(truth);
  EXPECT_FALSE(log.close());
  std::ifstream stream(file);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(text,
            "# setpoint and drive are in the drive unit of the axis; time is CLOCK_MONOTONIC or virtual\n"
            "time_s,axis,sync_counter,setpoint,drive,hysteresis_um,position_um,measured_um\n"
            "1.500000000,y,7,50.250000,50.125000000,15.500000000,15.250000000,15.250300000\n");
}

TEST(TruthLog, ReportsAFileThatCannotBeWritten) {
  EXPECT_THROW(TruthLog("/no/such/folder/truth.csv", {"x"}), std::runtime_error);
}

TEST(TruthLog, ReportsLostRowsOnAFullDisk) {
  TruthLog log("/dev/full", {"x", "y"});
  for (int i = 0; i < 1000; ++i) log.write(truth);
  const std::string lost = log.close().value_or("");
  EXPECT_NE(lost.find("/dev/full: cannot be written: No space left on device"), std::string::npos) << lost;
}

}  // namespace
}  // namespace hystcan::app::truth_log_test
