// hystcan excite, rehearsed: its datasets and its errors.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "config/files/dataset_file.h"
#include "tests/app/command_line/cli.h"

namespace hystcan::excite_test {
namespace {

using identification::Dataset;

class Excite : public Cli {
 protected:
  /// Runs `excite piezo.toml --output record.csv --overwrite --rehearse` with more options.
  std::vector<std::string> rehearsal(const std::vector<std::string>& options = {}) const {
    std::vector<std::string> command{HYSTCAN_PROGRAM,    "excite",      path("piezo.toml"), "--output",
                                     path("record.csv"), "--overwrite", "--rehearse"};
    command.insert(command.end(), options.begin(), options.end());
    return command;
  }
  Dataset rehearsed(const std::vector<std::string>& options = {}) const {
    Process program(rehearsal(options));
    EXPECT_EQ(program.wait(), done) << program.err();
    return config::load_dataset(shipped / "record.csv").dataset;
  }
  bool kept() const { return std::filesystem::exists(shipped / "record.csv"); }
};

TEST_F(Excite, RecordsLoopsOverTheWholeRangeWithUnitsAndOneRowPerCycle) {
  const Dataset record = rehearsed();
  EXPECT_EQ(record.input_unit, "V");
  EXPECT_EQ(record.output_unit, "um");
  const auto [least, most] = std::ranges::minmax(record.input);
  EXPECT_EQ(least, 0.0);
  EXPECT_EQ(most, 100.0);
  EXPECT_GT(std::ranges::max(record.output), 29.0);
  EXPECT_EQ(record.time_s.front(), 0.0);
  for (std::size_t i = 1; i < record.size(); ++i)
    ASSERT_NEAR(record.time_s[i] - record.time_s[i - 1], 1e-3, 1e-12) << "virtual time";
}

TEST_F(Excite, WritesSignalAxisAndUnitsIntoTheFile) {
  rehearsed({"--axis", "y"});
  EXPECT_TRUE(read("record.csv")
                  .starts_with("# hysteresis excitation of axis y at 1000 Hz, rehearsed with piezo.toml\n"))
      << read("record.csv").substr(0, 200);
}

/// Mean output at an input on the rising or the falling branch.
double mean_output(const Dataset& record, double input, double way) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 1; i < record.size(); ++i) {
    if (std::abs(record.input[i] - input) > 1.0 || (record.input[i] - record.input[i - 1]) * way <= 0.0)
      continue;
    sum += record.output[i];
    ++count;
  }
  return sum / count;
}

TEST_F(Excite, MajorLoopShowsTheTwinsHysteresisWithoutALagOfTheDataset) {
  const Dataset record = rehearsed({"--period", "5", "--levels", "0"});
  // In piezo.plant.toml, the descending curve is about 4.5 um above the ascending curve in the middle.
  const double width_um = mean_output(record, 50.0, -1.0) - mean_output(record, 50.0, 1.0);
  EXPECT_GT(width_um, 3.0);
  EXPECT_LT(width_um, 6.0);
  // Half the speed changes only the effect of a lag, in each direction by one cycle:
  //   1 ms * 40 V/s * 0.3 um/V = 0.012 um
  const Dataset slower = rehearsed({"--period", "10", "--levels", "0"});
  EXPECT_NEAR(mean_output(slower, 50.0, -1.0) - mean_output(slower, 50.0, 1.0), width_um, 0.03);
}

TEST_F(Excite, StepAndChirpStayNearTheWorkingPoint) {
  for (const char* signal : {"step", "chirp"}) {
    const Dataset record = rehearsed({"--signal", signal, "--low", "20", "--high", "60", "--amplitude", "3"});
    const auto [least, most] = std::ranges::minmax(record.input);
    EXPECT_GE(least, 37.0);
    EXPECT_LE(most, 43.0);
    EXPECT_GT(most - least, 5.9) << signal;
  }
}

TEST_F(Excite, DrivesAnAxisInAmperes) {
  Process program({HYSTCAN_PROGRAM, "excite", path("galfenol.toml"), "--output", path("record.csv"),
                   "--rehearse", "--period", "4"});
  ASSERT_EQ(program.wait(), done) << program.err();
  const Dataset record = config::load_dataset(shipped / "record.csv").dataset;
  EXPECT_EQ(record.input_unit, "A");
  EXPECT_EQ(std::ranges::max(record.input), 3.0);
}

TEST_F(Excite, KeepsTheRowsBeforeAFault) {
  shipped.edit("piezo.toml", "position_max_um    = 34.0", "position_max_um    = 28.0");
  Process program(rehearsal({"--low", "0", "--high", "100"}));
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find("axis x faulted"), std::string::npos) << program.err();
  EXPECT_NE(program.err().find("position implausible"), std::string::npos) << program.err();
  const Dataset record = config::load_dataset(shipped / "record.csv").dataset;
  EXPECT_NE(program.err().find("stopped after " + std::to_string(record.size()) + " rows"), std::string::npos)
      << program.err();
  EXPECT_LE(std::ranges::max(record.output), 28.0);
  EXPECT_GT(std::ranges::max(record.output), 27.5);
}

TEST_F(Excite, ReducesItsDefaultRangeAgainIfALimitTrips) {
  shipped.edit("piezo.toml", "position_max_um    = 34.0", "position_max_um    = 28.0");
  Process program(rehearsal());
  EXPECT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.err().find("repeating the excitation with a smaller range, 0 to 60 V"), std::string::npos)
      << program.err();
  const Dataset record = config::load_dataset(shipped / "record.csv").dataset;
  EXPECT_EQ(std::ranges::min(record.input), 0.0) << "three fifths about the safe drive";
  EXPECT_EQ(std::ranges::max(record.input), 60.0);
}

TEST_F(Excite, DerivesItsDefaultRangeFromASmallLoop) {
  shipped.edit("piezo.toml", "position_max_um    = 34.0", "position_max_um    = 15.0");
  for (const auto& [was, is] :
       {std::pair{"high_um      = 27.0", "high_um = 11.0"},
        {"high_um      = 25.0", "high_um = 11.0"},
        {"levels_um    = [27.0, 5.0, 24.0, 8.0, 21.0, 11.0, 18.0, 14.0, 15.0]", "levels_um = [5.0]"},
        {"levels_um    = [25.0, 6.0, 22.0, 9.0, 19.0, 12.0, 16.0]", "levels_um = [5.0]"}})
    shipped.edit("piezo.toml", was, is);
  Process program(rehearsal());
  EXPECT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.err().find("a larger range moves the position out of its limits"), std::string::npos)
      << program.err();
  EXPECT_LE(std::ranges::max(config::load_dataset(shipped / "record.csv").dataset.output), 15.0);
}

TEST_F(Excite, NeedsNoModel) {
  rehearsed();
  const std::string with_a_model = read("record.csv");
  shipped.edit("piezo.toml", "model              = \"piezo.model.toml\"", "model = \"not_yet.model.toml\"");
  rehearsed();
  EXPECT_TRUE(read("record.csv") == with_a_model);
  shipped.edit("piezo.toml", "model = \"not_yet.model.toml\"\n", "");
  rehearsed();
  EXPECT_TRUE(read("record.csv") == with_a_model);
}

TEST_F(Excite, ProposesASecondRateAndAnUnseenRecord) {
  Process program(rehearsal());
  EXPECT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.err().find("--period 8 --output"), std::string::npos) << program.err();
  EXPECT_NE(program.err().find("record.unseen.csv"), std::string::npos) << program.err();
}

TEST_F(Excite, UsesAHundredPeriodsOfTheResonanceForALoop) {
  shipped.edit("piezo.toml", "resonance_Hz           = 500.0", "resonance_Hz           = 25.0");
  shipped.edit("piezo.toml", "ki_per_s           = 409.0", "ki_per_s           = 4.0");
  Process program(rehearsal({"--levels", "0", "--cycles", "1"}));
  EXPECT_EQ(program.wait(), done) << program.err();
  EXPECT_NEAR(config::load_dataset(shipped / "record.csv").dataset.time_s.back(), 4.0, 0.1);
}

TEST_F(Excite, WritesNoFileWithoutRows) {
  shipped.edit("piezo.toml", "wipe_slew_V_per_s  = 500.0 ", "wipe_slew_V_per_s  = 1e-3 ");
  Process program(rehearsal({"--low", "50"}));
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(program.err().find("nothing is written"), std::string::npos) << program.err();
  EXPECT_FALSE(kept());
}

TEST_F(Excite, RefusesAnExcitationOutsideTheLimits) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> refused{
      {{"--low", "-1"}, "expected a drive within drive_min and drive_max, 0 and 100"},
      {{"--high", "101"}, "expected a drive within drive_min and drive_max"},
      {{"--low", "60", "--high", "50"}, "expected less than --high"},
      {{"--low", "nan"}, "--low: nan, expected a finite number"},
      {{"--period", "0.001"}, "expected at most slew_per_s"},
      {{"--period", "0"}, "--period: 0, expected a finite number > 0"},
      {{"--slew", "-5"}, "--slew: -5, expected a finite number > 0"},
      {{"--period", "1", "--slew", "5"}, "excludes"},
      {{"--signal", "sine"}, "sine"},
      {{"--signal", "chirp", "--frequency-to", "600"}, "half the cycle rate"},
      {{"--signal", "chirp", "--levels", "3"}, "--levels is not allowed with --signal chirp"},
      {{"--signal", "step", "--amplitude", "60"}, "expected a drive within drive_min and drive_max"},
      {{"--axis", "z"}, "no axis z"},
      {{"--interface", "vcan0"}, "excludes"}};
  for (const auto& [options, reason] : refused) {
    Process program(rehearsal(options));
    EXPECT_EQ(program.wait(), bad_input) << options.back();
    EXPECT_NE(program.err().find(reason), std::string::npos) << program.err();
    EXPECT_FALSE(kept());
  }
}

TEST_F(Excite, RefusesAnExistingRecordBeforeAnyMotion) {
  write("old.csv", "precious");
  Process program({HYSTCAN_PROGRAM, "excite", path("piezo.toml"), "--rehearse", "--output", path("old.csv")});
  EXPECT_EQ(program.wait(), bad_input);
  EXPECT_EQ(program.err(),
            "hystcan: " + path("old.csv") + ": exists already, expected another name, or --overwrite\n");
  EXPECT_EQ(read("old.csv"), "precious");
}

TEST_F(Excite, FailsBeforeAnyMotionIfItCannotWrite) {
  Process program(
      {HYSTCAN_PROGRAM, "excite", path("piezo.toml"), "--rehearse", "--output", path("no/l.csv")});
  EXPECT_EQ(program.wait(), failed);
  EXPECT_EQ(program.err(),
            "hystcan: " + path("no/l.csv") + ": cannot be written: No such file or directory\n");
}

// 30.8 um - x stays within the position limits.
TEST_F(Excite, RefusesAMirroredSensorAtTheFirstSmallLoop) {
  shipped.edit("piezo.toml", "[axis.twin]",
               "[axis.twin]\nsensor.gain_error_percent = -200.0\nsensor.offset_um = 30.8");
  Process program(rehearsal());
  EXPECT_EQ(program.wait(), failed);
  EXPECT_NE(
      program.err().find(
          "x: 0 to 10 V: the output falls when the input rises, expected a rising output: change the sign of "
          "the output; nothing is written"),
      std::string::npos)
      << program.err();
  EXPECT_FALSE(kept());
}

}  // namespace
}  // namespace hystcan::excite_test
