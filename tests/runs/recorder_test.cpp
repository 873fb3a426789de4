#include "runs/recorder.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <random>
#include <set>
#include <thread>

#include "rehearsal/rehearsal.h"
#include "runs/run.h"
#include "tests/runs/scratch_runs.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/patience.h"

namespace hystcan::runs::recorder_test {
namespace {

using std::chrono::milliseconds;
using Recording = ScratchRuns;

TEST_F(Recording, ContainsEveryCycleWithItsDescription) {
  std::filesystem::path run;
  {
    Recorder recorder = make();
    run = recorder.start();
    EXPECT_TRUE(is_being_recorded(run));
    for (std::uint64_t cycle = 1; cycle <= 1000; ++cycle)
      for (const std::size_t axis : {0U, 1U}) recorder.add(tracked(cycle, axis));
    recorder.finish();
  }
  EXPECT_FALSE(is_being_recorded(run));
  const RecordedRun read(run);
  EXPECT_EQ(read.info().rows, 2000u);
  EXPECT_EQ(read.info().rows_lost, 0u);
  EXPECT_EQ(read.info().config, "piezo.toml");
  EXPECT_FALSE(read.info().version.empty());
  EXPECT_FALSE(read.info().host.empty());
  EXPECT_FALSE(read.info().ended.empty());
  EXPECT_EQ(read.info().axes.at(0).drive_unit, "V");
  EXPECT_DOUBLE_EQ(read.info().axes.at(1).rms_um, 0.5);
  const auto is_kp = [](const auto& setting) { return setting.first == "axis[0].control.kp"; };
  EXPECT_TRUE(std::ranges::any_of(read.info().settings, is_kp));
  for (const char* file : {"piezo.toml", "piezo.model.toml", "piezo.plant.toml", "hystcan.dbc"})
    EXPECT_EQ(text_of(run / "config" / file),
              text_of(std::filesystem::path(HYSTCAN_SOURCE_DIR) / "config" / file));
}

// The thread of the control link adds records; a page or a command starts and stops.
TEST_F(Recording, BeginsAndEndsWhileRowsArrive) {
  Recorder recorder = make();
  std::atomic<bool> is_over = false;
  std::uint64_t cycle = 0;
  std::thread control([&] {
    while (!is_over) recorder.add(tracked(++cycle));
  });
  std::set<std::filesystem::path> runs;
  for (int i = 0; i < 5; ++i) {
    runs.insert(recorder.start());
    EXPECT_TRUE(recorder.status().is_recording);
    recorder.finish();
  }
  is_over = true;
  control.join();
  EXPECT_EQ(runs.size(), 5U);
  for (const std::filesystem::path& run : runs) EXPECT_FALSE(RecordedRun(run).info().ended.empty()) << run;
}

TEST_F(Recording, PreservesTheCyclesOfARehearsal) {
  Recorder recorder = make();
  const std::filesystem::path run = recorder.start();
  std::vector<double> positions;
  rehearsal::Rehearsal loop({.controller = config::controller_config(config),
                             .twin = config::twin_config(config),
                             .database = config.database},
                            [&](const controller::CycleRecord& record) {
                              recorder.add(record);
                              if (record.axis == 0) positions.push_back(record.report.position_um);
                            });
  loop.start();
  loop.run_for(std::chrono::seconds(3));
  recorder.finish();
  const RecordedRun read(run);
  const std::vector<std::string> names{"position_um", "memory_depth", "previewed_um"};
  const Columns columns = read.read(0, names);
  ASSERT_EQ(columns[0].size(), positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) ASSERT_NEAR(columns[0][i], positions[i], 1e-6);
  EXPECT_GE(columns[1].back(), 1.0) << "branches in the memory of the model";
  EXPECT_EQ(read.signals(0, names)[2].unit, "um");
}

TEST_F(Recording, BeginsTheNextPartWhenOneIsFull) {
  config.record.part_MB = 0.05;
  Recorder recorder = make();
  const std::filesystem::path run = recorder.start();
  for (std::uint64_t cycle = 1; cycle <= 3000; ++cycle) {
    recorder.add(tracked(cycle));
    if (cycle % 1000 != 0) continue;  // 200 kB: more than a part, which is closed after it is written
    ASSERT_TRUE(support::eventually([&] { return parts_of(run).size() > cycle / 1000; })) << cycle;
  }
  recorder.finish();
  const std::vector<std::string> names{"cycle"};
  const Columns cycles = RecordedRun(run).read(0, names);
  ASSERT_EQ(cycles[0].size(), 3000u);
  for (std::size_t i = 0; i < 3000; ++i) ASSERT_EQ(cycles[0][i], static_cast<double>(i + 1));
}

TEST_F(Recording, DescribesAPartByItsRun) {
  config.record.part_MB = 0.05;
  Recorder recorder = make();
  const std::filesystem::path run = recorder.start();
  for (std::uint64_t cycle = 1; cycle <= 1000; ++cycle) recorder.add(tracked(cycle));
  ASSERT_TRUE(support::eventually([&] { return parts_of(run).size() >= 2; }));
  recorder.finish();
  const RecordedRun part(parts_of(run).front());
  EXPECT_EQ(part.info().axes.front().drive_unit, "V");
  EXPECT_EQ(part.info().rows, 1000u);
}

TEST_F(Recording, QuotesTheChangesOfSettingsAsCsv) {
  Recorder recorder = make();
  const std::filesystem::path run = recorder.start();
  recorder.add(std::vector<config::Change>{{"axis[0].control.kp", "0.0", "0.1"},
                                           {"axis[0].control.structure", R"("pi")", R"("inverse+pi")"},
                                           {"axis[0].control.notch", "[1, 2]", ""}});
  recorder.finish();
  const std::string changes = text_of(run / "changes.csv");
  for (const char* row :
       {"Z,axis[0].control.kp,0.0,0.1\n", R"(Z,axis[0].control.structure,"""pi""","""inverse+pi""")",
        R"(Z,axis[0].control.notch,"[1, 2]",)"})
    EXPECT_NE(changes.find(row), std::string::npos) << changes;
}

TEST_F(Recording, RefusesASecondRunAndCanBeginAgainAfterTheEnd) {
  Recorder recorder = make();
  const std::filesystem::path first = recorder.start();
  EXPECT_THROW(recorder.start(), std::runtime_error);
  EXPECT_EQ(recorder.stop(), first);
  ASSERT_TRUE(support::eventually([&] { return !recorder.status().is_recording; }));
  EXPECT_TRUE(recorder.stop().empty());
  std::this_thread::sleep_for(milliseconds(2));  // a run is named for its millisecond
  EXPECT_NE(recorder.start(), first);
}

/// The file size limit of a process acts like a full disk: a write fails in the middle of a row.
bool is_closed(const std::filesystem::path& file) {
  std::error_code ignored;
  for (const auto& open : std::filesystem::directory_iterator("/proc/self/fd"))
    if (std::filesystem::read_symlink(open, ignored) == std::filesystem::canonical(file)) return false;
  return true;
}

TEST_F(Recording, EndsWithAWarningAndWholeRowsIfTheDiskIsFull) {
  Recorder recorder = make();
  const std::filesystem::path run = recorder.start();
  std::optional<support::FileSizeLimit> full(100'000);
  for (std::uint64_t cycle = 1; recorder.status().is_recording; ++cycle) {
    recorder.add(tracked(cycle));
    if (cycle % 2000 == 0) std::this_thread::sleep_for(milliseconds(20));
  }
  full.reset();
  recorder.add(tracked(1));
  const RunWriter::Status status = recorder.status();
  EXPECT_NE(status.failure.find("File too large"), std::string::npos) << status.failure;
  EXPECT_GT(status.rows_lost, 0u);
  recorder.finish();
  ASSERT_FALSE(logged().empty());
  EXPECT_NE(logged()[0].find("control continues"), std::string::npos) << logged()[0];
  EXPECT_TRUE(text_of(run / "cycles_0001.csv").ends_with("\n"));
  EXPECT_GT(RecordedRun(run).info().rows, 0u);
  EXPECT_TRUE(is_closed(run / "cycles_0001.csv")) << "who removes it has the space back";
}

TEST_F(Recording, EndsWithAWarningIfItsFolderIsRemoved) {
  Recorder recorder = make();
  std::filesystem::remove_all(recorder.start());
  for (std::uint64_t cycle = 1; recorder.status().is_recording; ++cycle) {
    recorder.add(tracked(cycle));
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_NE(recorder.status().failure.find("was removed"), std::string::npos);
}

TEST_F(Recording, ReportsWhyItCannotBegin) {
  config.record.folder = "/dev/null/runs";
  Recorder recorder = make();
  EXPECT_THROW(recorder.start(), std::exception);
  EXPECT_FALSE(recorder.status().is_recording);
}

TEST_F(Recording, LeavesNoFolderIfItCannotBegin) {
  Recorder recorder = make();
  for (const rlim_t most : {0U, 100U, 1'000U}) {
    const support::FileSizeLimit full(most);
    EXPECT_THROW(recorder.start(), std::exception) << most;
    EXPECT_TRUE(std::filesystem::is_empty(config.record.folder)) << most;
  }
}

/// Records until it is killed, and reports the number of written bytes through the pipe.
[[noreturn]] void record_forever(Recorder& recorder, int pipe,
                                 const std::function<controller::CycleRecord(std::uint64_t)>& next) {
  recorder.start();
  for (std::uint64_t cycle = 1, reported = 0;; ++cycle) {
    recorder.add(next(cycle));
    if (const std::uint64_t bytes = recorder.status().bytes; bytes != reported) {
      reported = bytes;
      if (::write(pipe, &reported, sizeof reported) != sizeof reported) _exit(1);
    }
    if (cycle % 20 == 0) std::this_thread::sleep_for(milliseconds(1));
  }
}

/// Twenty times at a random moment. tests/hil/recording_test.cpp tests the lost time in the guest.
TEST_F(Recording, KeepsWrittenRowsAfterAKill) {
  std::mt19937 random(20261123);
  std::uniform_int_distribution<int> moment_ms(0, 600);
  for (int round = 0; round < 20; ++round) {
    config.record.folder = folder / std::to_string(round);
    int ends[2] = {};
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      Recorder recorder = make();
      record_forever(recorder, ends[1], [](std::uint64_t cycle) { return tracked(cycle); });
    }
    ::close(ends[1]);
    std::uint64_t reported = 0;
    ASSERT_EQ(::read(ends[0], &reported, sizeof reported), static_cast<ssize_t>(sizeof reported));
    std::this_thread::sleep_for(milliseconds(moment_ms(random)));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    while (::read(ends[0], &reported, sizeof reported) == sizeof reported) {
    }
    ::close(ends[0]);
    const std::vector<std::filesystem::path> runs = runs_in(config.record.folder);
    ASSERT_EQ(runs.size(), 1U);
    EXPECT_GE(std::filesystem::file_size(runs.front() / "cycles_0001.csv"), reported);
    const RecordedRun run(runs.front());
    EXPECT_TRUE(run.info().ended.empty());
    const std::vector<std::string> names{"cycle"};
    const Columns read = run.read(0, names);
    ASSERT_GT(read[0].size(), 0U);
    for (std::size_t i = 0; i < read[0].size(); ++i)
      ASSERT_EQ(read[0][i], static_cast<double>(i + 1)) << "no row is missing before the last one";
  }
}

}  // namespace
}  // namespace hystcan::runs::recorder_test
