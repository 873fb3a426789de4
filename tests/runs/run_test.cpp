#include "runs/run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "config/document/error.h"
#include "controller/telemetry.h"
#include "tests/runs/scratch_runs.h"

namespace hystcan::runs::run_test {
namespace {

using ARecordedRun = ScratchRuns;

TEST_F(ARecordedRun, IsReadBetweenTwoTimes) {
  Recorder recorder = make();
  const auto folder_of_run = recorder.start();
  for (std::uint64_t cycle = 1; cycle <= 100; ++cycle) recorder.add(tracked(cycle));
  recorder.finish();
  const std::vector<std::string> names{"cycle"};
  const Signals read = RecordedRun(folder_of_run).read(0, names, {.from_s = 0.0205, .to_s = 0.0302});
  EXPECT_EQ(read.columns[0], (std::vector<double>{21, 22, 23, 24, 25, 26, 27, 28, 29, 30}));
}

TEST_F(ARecordedRun, ThatWasKilledIsSummarisedFromItsRows) {
  std::filesystem::path copy;
  {
    Recorder recorder = make();
    const auto run = recorder.start();
    controller::CycleRecord faulted = tracked(51, 1);
    faulted.report.state = controller::AxisState::faulted;
    faulted.report.cause = controller::Cause::following_error;
    for (std::uint64_t cycle = 1; cycle <= 50; ++cycle) recorder.add(tracked(cycle, 1));
    recorder.add(faulted);
    copy = config.record.folder / "run_copy";
    while (std::ranges::count(text_of(run / "cycles_0001.csv"), '\n') < 2 + 51)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::filesystem::copy(run, copy, std::filesystem::copy_options::recursive);
  }
  const RecordedRun run(copy);
  EXPECT_TRUE(run.info().ended.empty());
  EXPECT_EQ(run.info().rows, 51u);
  EXPECT_EQ(run.info().axes.at(1).summary.tracked_rows, 50u);
  EXPECT_DOUBLE_EQ(run.info().axes.at(1).summary.rms_um, 0.5);
  ASSERT_EQ(run.info().axes.at(1).summary.faults.size(), 1u);
  EXPECT_EQ(run.info().axes.at(1).summary.faults[0].cause, "following error");
}

TEST_F(ARecordedRun, MayBeASingleCsvOfCycles) {
  {
    controller::CsvLog csv(folder / "one.csv", {"x", "y"});
    for (std::uint64_t cycle = 1; cycle <= 10; ++cycle) csv.write(tracked(cycle, cycle % 2));
  }
  const RecordedRun run(folder / "one.csv");
  ASSERT_EQ(run.info().axes.size(), 2u);
  EXPECT_EQ(run.info().rows, 10u);
  EXPECT_EQ(run.axis_index("x"), 1u) << "in the order in which they occur";
  EXPECT_THROW(run.axis_index("z"), config::Error);
}

TEST_F(ARecordedRun, IsRefusedWhereItIsNone) {
  EXPECT_THROW(RecordedRun(folder / "none"), config::Error);
  EXPECT_THROW(RecordedRun{folder}, config::Error) << "a folder without run.json";
  std::filesystem::create_directories(folder / "run_1");
  for (const char* text : {"", "{}", "[1]", "{\"hystcan_run\": 2}", "{\"hystcan_run\": 1, \"axes\": 3}"}) {
    std::ofstream(folder / "run_1" / "run.json") << text;
    EXPECT_THROW(RecordedRun(folder / "run_1"), config::Error) << text;
  }
}

}  // namespace
}  // namespace hystcan::runs::run_test
