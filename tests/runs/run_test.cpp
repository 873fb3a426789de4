#include "runs/run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "controller/telemetry.h"
#include "tests/runs/scratch_runs.h"
#include "tests/support/patience.h"
#include "tests/support/refusal.h"

namespace hystcan::runs::run_test {
namespace {

using ARecordedRun = ScratchRuns;

std::string refusal_of(const std::filesystem::path& run) {
  return support::refusal_of([&] { const RecordedRun read(run); });
}

TEST_F(ARecordedRun, IsReadBetweenTwoTimes) {
  Recorder recorder = make();
  const auto folder_of_run = recorder.start();
  for (std::uint64_t cycle = 1; cycle <= 100; ++cycle) recorder.add(tracked(cycle));
  recorder.finish();
  const std::vector<std::string> names{"cycle"};
  const Columns read = RecordedRun(folder_of_run).read(0, names, {.from_s = 0.0205, .to_s = 0.0302});
  EXPECT_EQ(read[0], (std::vector<double>{21, 22, 23, 24, 25, 26, 27, 28, 29, 30}));
}

TEST_F(ARecordedRun, IsSummarisedFromItsRowsAfterAKill) {
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
    ASSERT_TRUE(support::eventually(
        [&] { return std::ranges::count(text_of(run / "cycles_0001.csv"), '\n') >= 2 + 51; }));
    std::filesystem::copy(run, copy, std::filesystem::copy_options::recursive);
  }
  const RecordedRun run(copy);
  EXPECT_TRUE(run.info().ended.empty());
  EXPECT_EQ(run.info().rows, 51u);
  EXPECT_EQ(run.info().axes.at(1).tracked_rows, 50u);
  EXPECT_DOUBLE_EQ(run.info().axes.at(1).rms_um, 0.5);
  ASSERT_EQ(run.info().axes.at(1).faults.size(), 1u);
  EXPECT_EQ(run.info().axes.at(1).faults[0].cause, "following error");
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
  EXPECT_THROW(run.axis_index("z"), Error);
}

TEST_F(ARecordedRun, IsRefusedIfItIsInvalid) {
  EXPECT_THROW(RecordedRun(folder / "none"), Error);
  EXPECT_THROW(RecordedRun{folder}, Error) << "a folder without run.json";
  std::filesystem::create_directories(folder / "run_1");
  for (const auto& [text, reason] : std::map<std::string, std::string>{
           {"", "invalid JSON at byte 1"},
           {"{", "invalid JSON at byte 2"},
           {"{}", "hystcan_run is missing"},
           {"[1]", "not a JSON object"},
           {R"({"hystcan_run": 2})", "hystcan_run is 2, expected 1"},
           {R"({"hystcan_run": -1})", "hystcan_run is -1, expected a whole number"},
           {R"({"hystcan_run": 1e999})", "a number that is too large"},
           {R"({"hystcan_run": 1, "version": 3})", "version is 3, expected a text"},
           {R"({"hystcan_run": )" + std::string(1'000'000, '[') + std::string(1'000'000, ']') + "}",
            "hystcan_run is array"}}) {
    std::ofstream(folder / "run_1" / "run.json") << text;
    EXPECT_EQ(refusal_of(folder / "run_1").find((folder / "run_1" / "run.json").string() + ": " + reason), 0U)
        << refusal_of(folder / "run_1");
  }
}

TEST_F(ARecordedRun, IsRefusedIfItsRowCountIsInvalid) {
  std::filesystem::create_directories(folder / "run_1");
  for (const char* rows : {"-1", "1e30", "1.5", "\"7\"", "null", "[]"}) {
    nlohmann::json info = to_json(RunInfo{});
    info["rows"] = nlohmann::json::parse(rows);
    std::ofstream(folder / "run_1" / "run.json") << info;
    EXPECT_NE(refusal_of(folder / "run_1").find("expected a whole number"), std::string::npos) << rows;
  }
}

using RunInfoFile = ScratchRuns;

TEST_F(RunInfoFile, ReplacesTheFormerOneAndLeavesNoOtherFile) {
  RunInfo info = describe(config, {}, "test");
  for (const char* ended : {"", "2026-11-26T09:00:00.000Z"}) {
    info.ended = ended;
    write_run_info(folder, info);
  }
  EXPECT_EQ(read_run_info(folder).ended, "2026-11-26T09:00:00.000Z");
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    EXPECT_EQ(entry.path().filename(), info_name);
}

TEST_F(RunInfoFile, NeedsItsFolder) {
  EXPECT_THROW(write_run_info(folder / "none", describe(config, {}, "test")), RunError);
}

}  // namespace
}  // namespace hystcan::runs::run_test
