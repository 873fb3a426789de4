// `hystcan identify` and `hystcan validate` with recorded runs.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/live/rehearsal_setup.h"
#include "app/stage/dataset_input.h"
#include "app/stage/open_loop.h"
#include "controller/excitation_dataset.h"
#include "tests/app/command_line/cli.h"
#include "tests/runs/scratch_runs.h"

namespace hystcan::recorded_run_test {
namespace {

using nlohmann::json;

class RecordedRuns : public runs::ScratchRuns {
 protected:
  std::string path(const char* name) const { return (folder / name).string(); }
  static Process hystcan(std::vector<std::string> words) {
    words.insert(words.begin(), HYSTCAN_PROGRAM);
    return Process(words);
  }

  /// One pass of both references of the shipped stage, from power-on.
  std::string closed_loop() {
    runs::Recorder recorder = make();
    const std::string run = recorder.start().string();
    rehearsal::run_once(app::rehearsal_setup(config), 0.0,
                        [&](const controller::CycleRecord& record) { recorder.add(record); });
    return run;
  }
  std::string excitation(const char* csv) const {
    Process excite = hystcan({"excite", HYSTCAN_SOURCE_DIR "/config/piezo.toml", "--axis", "x", "--rehearse",
                              "--period", "1", "--output", path(csv)});
    EXPECT_EQ(excite.wait(), done) << excite.err();
    return path(csv);
  }
  static json printed(Process program) {
    EXPECT_EQ(program.wait(), done) << program.err();
    return json::parse(program.out(), nullptr, false);
  }
  json identified(const std::vector<std::string>& data) const {
    std::vector<std::string> words{"identify", "--output", path("found.toml"), "--overwrite", "--json"};
    words.insert(words.end(), data.begin(), data.end());
    return printed(hystcan(words));
  }
  static void expect_refused(Process program, const std::string& words) {
    EXPECT_EQ(program.wait(), bad_input) << program.err();
    EXPECT_NE(program.err().find(words), std::string::npos) << program.err();
  }

  /// Cycle i at i s, with drive i and position 10 i. w: waiting, i: initialising at drive 7, t: tracking, m:
  /// tracking without a sample, blank: lost.
  void write_cycles(const char* name, const std::string& states) const {
    std::ofstream out(folder / name);
    out << "cycle,time_s,axis,state,position_um,drive,sample_missing\n";
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (states[i] == ' ') continue;
      const char* state = states[i] == 'w' ? "waiting" : states[i] == 'i' ? "initialising" : "tracking";
      out << i << ',' << i << ",x," << state << ',' << 10 * i << ',' << (states[i] == 'i' ? 7 : i) << ','
          << (states[i] == 'm') << '\n';
    }
  }
  std::vector<double> times(const std::string& states, const runs::TimeSpan& span = {}) const {
    write_cycles("cycles.csv", states);
    return app::load_run(folder / "cycles.csv", "", span).time_s;
  }
};

using Times = std::vector<double>;

// The run has its start-up, 500 V/s up and down, a triangle of 10 Hz and a staircase; the excitation has
// loops of 1 s.
TEST_F(RecordedRuns, InClosedLoopIdentifyAModelOfTheExcitation) {
  identified({closed_loop(), "--axis", "x"});
  const json figures = printed(hystcan({"validate", path("found.toml"), excitation("x.csv"), "--json"}));
  EXPECT_LT(figures["rms_percent"].get<double>(), 0.05);
}

TEST_F(RecordedRuns, HaveTheSameDelayAsTheCsvOfTheExcitation) {
  const config::Config driven = app::in_open_loop(
      app::chosen_axis_of(config, {}),
      controller::Excitation::Hysteresis{.low = 0.0, .high = 100.0, .slew_per_s = 500.0, .levels = 2});
  config = driven;
  runs::Recorder recorder = make();
  const std::string run = recorder.start().string();
  controller::ExcitationDataset dataset;
  std::ofstream csv(folder / "x.csv");
  csv.precision(17);
  csv << "time_s,input,output\n";
  app::OpenLoopOptions options;
  options.rehearse = true;
  app::drive_in_open_loop(driven, config::twin_config(config::load(config.file)), options,
                          [&](const controller::CycleRecord& record) {
                            recorder.add(record);
                            if (const auto row = dataset.add(record))
                              csv << row->time_s << ',' << row->input << ',' << row->output << '\n';
                          });
  recorder.finish();
  csv.close();
  const double of_run_s = identified({run, "--order", "3"})["delay_s"];
  const double of_csv_s = identified({path("x.csv"), "--order", "3"})["delay_s"];
  EXPECT_GT(of_csv_s, 3e-4);
  EXPECT_NEAR(of_run_s, of_csv_s, 2e-5) << "a cycle is 1 ms";
}

TEST_F(RecordedRuns, CanBeCombinedWithCsvFiles) {
  const json found = identified({closed_loop(), excitation("x.csv"), "--axis", "x", "--order", "3"});
  ASSERT_EQ(found["records"].size(), 2U);
  EXPECT_LT(found["rms_percent"].get<double>(), 0.2);
}

// Half a second of the staircase, 27 to 72 V of 0 to 100 V. The curves of the old model are 3 % off: its
// error on the excitation is 0.51 %; the error of a model from the staircase alone is at least 20 %.
TEST_F(RecordedRuns, ImproveAnOldModelEvenIfTheirRangeIsSmall) {
  const std::string old = HYSTCAN_SOURCE_DIR "/config/piezo.model.toml";
  const json found = identified({closed_loop(), "--axis", "x", "--from", "2.5", "--start", old});
  const json figures = printed(hystcan({"validate", path("found.toml"), excitation("x.csv"), "--json"}));
  EXPECT_LT(figures["rms_percent"].get<double>(), 0.3);
  EXPECT_LT(found["rms_percent"].get<double>(), 0.1);
  ASSERT_EQ(found["records"].size(), 1U);
  EXPECT_TRUE(found["findings"].back().get<std::string>().ends_with(
      "the curves beyond these inputs and the parameters that the datasets do not determine are copied "
      "from " +
      old + " (a model without creep)"))
      << found["findings"];
}

TEST_F(RecordedRuns, ReplaceAnOldModelIfTheyCoverTheWholeLoop) {
  identified({closed_loop(), "--axis", "x", "--start", HYSTCAN_SOURCE_DIR "/config/piezo.model.toml"});
  const json figures = printed(hystcan({"validate", path("found.toml"), excitation("x.csv"), "--json"}));
  EXPECT_LT(figures["rms_percent"].get<double>(), 0.05) << "the old model: 0.51";
}

TEST_F(RecordedRuns, CanBeValidated) {
  Process program =
      hystcan({"validate", HYSTCAN_SOURCE_DIR "/config/piezo.model.toml", closed_loop(), "--axis", "y"});
  ASSERT_EQ(program.wait(), done) << program.err();
  EXPECT_NE(program.out().find(": predicted with "), std::string::npos) << program.out();
  EXPECT_NE(program.err().find(": axis y, "), std::string::npos) << program.err();
}

TEST_F(RecordedRuns, AreRefusedIfTheAxisIsAmbiguous) {
  const std::string run = closed_loop();
  expect_refused(hystcan({"identify", run, "--output", path("found.toml")}),
                 run + ": has 2 axes; select one with --axis: x, y");
}

TEST_F(RecordedRuns, AreRefusedIfTheAxisIsUnknown) {
  const std::string run = closed_loop();
  expect_refused(hystcan({"identify", run, "--axis", "z", "--output", path("found.toml")}),
                 run + ": no axis z, expected one of x, y");
}

TEST_F(RecordedRuns, AreRefusedIfTheyAreEmpty) {
  runs::Recorder recorder = make();
  const std::string run = recorder.start().string();
  recorder.finish();
  expect_refused(hystcan({"identify", run, "--output", path("found.toml")}), run + ": no rows");
}

TEST_F(RecordedRuns, RefuseAFolderThatIsNotARun) {
  expect_refused(hystcan({"identify", folder.string(), "--output", path("found.toml")}),
                 path("run.json") + ": cannot be read");
}

TEST_F(RecordedRuns, RefuseOptionsForColumns) {
  write_cycles("cycles.csv", "wttttt");
  for (const char* option : {"--columns=1,2,3", "--rate=1000", "--output-scale=2"})
    expect_refused(hystcan({"identify", path("cycles.csv"), option, "--output", path("found.toml")}),
                   "--columns, --rate, --output-scale and --output-from are not allowed with a recorded run");
}

TEST_F(RecordedRuns, AreRequiredForTheOptionAxis) {
  expect_refused(hystcan({"identify", excitation("x.csv"), "--axis", "x", "--output", path("found.toml")}),
                 "--axis is x, expected a recorded run, or --for");
}

TEST_F(RecordedRuns, PairAPositionWithTheDriveOfTheCycleBefore) {
  write_cycles("cycles.csv", "wttttt");
  const auto dataset = app::load_run(folder / "cycles.csv", "", {});
  EXPECT_EQ(dataset.time_s, (Times{3, 4, 5}));
  EXPECT_EQ(dataset.input, (Times{2, 3, 4}));
  EXPECT_EQ(dataset.output, (Times{30, 40, 50}));
}

TEST_F(RecordedRuns, BeginWhenTheDriveFirstMoves) { EXPECT_EQ(times("wiiiiittt"), (Times{6, 7, 8})); }

TEST_F(RecordedRuns, LeaveOutACycleWithoutASample) { EXPECT_EQ(times("ttttmtt"), (Times{2, 3, 5, 6})); }

TEST_F(RecordedRuns, AreTheLongestStretchWithoutALostCycle) {
  EXPECT_EQ(times("tttt tttttt tt"), (Times{7, 8, 9, 10}));
}

TEST_F(RecordedRuns, AreReadWithinTheInterval) {
  EXPECT_EQ(times("tttttttttt", {.from_s = 3.0, .to_s = 7.0}), (Times{5, 6, 7}));
}

TEST_F(RecordedRuns, AreRefusedIfTheAxisIsNeverDriven) {
  write_cycles("cycles.csv", "wwwwww");
  expect_refused(hystcan({"identify", path("cycles.csv"), "--output", path("found.toml")}),
                 path("cycles.csv") + ": axis x is not driven in these cycles");
}

}  // namespace
}  // namespace hystcan::recorded_run_test
