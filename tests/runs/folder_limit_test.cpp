#include "runs/run_folder.h"

#include <gtest/gtest.h>

#include "tests/runs/scratch_runs.h"

namespace hystcan::runs::folder_limit_test {
namespace {

class FolderLimit : public ScratchRuns {
 protected:
  /// A run of slightly more than 1 MB.
  std::filesystem::path add(const std::string& name, bool faulted = false) {
    const std::filesystem::path run = config.record.folder / name;
    std::filesystem::create_directories(run);
    RunInfo info = describe(config, {}, "test");
    if (faulted) info.axes[0].faults.push_back({"following error", 1.0});
    write_run_info(run, info);
    std::ofstream(run / "cycles_0001.csv") << std::string(1'000'000, '\n');
    return run;
  }
  LimitOutcome keep(const std::filesystem::path& current, std::uintmax_t bytes) const {
    return keep_limit(config.record.folder, current, bytes);
  }
};

TEST_F(FolderLimit, RemovesNothingIfThereIsEnoughSpace) {
  const auto current = add("run_3");
  add("run_1");
  EXPECT_TRUE(keep(current, 3'000'000).removed.empty());
}

TEST_F(FolderLimit, RemovesTheOldestRunWithoutAFaultFirst) {
  add("run_1", true);
  add("run_2");
  add("run_3");
  const auto current = add("run_4");
  EXPECT_EQ(keep(current, 3'500'000).removed, std::vector<std::string>{"run_2"});
  EXPECT_EQ(keep(current, 2'500'000).removed, std::vector<std::string>{"run_3"});
  EXPECT_EQ(keep(current, 1'500'000).removed, std::vector<std::string>{"run_1"});
}

TEST_F(FolderLimit, TreatsADamagedRunAsOneWithAFault) {
  std::ofstream(add("run_1") / info_name) << "{\"axes\": [{\"faults\": 1e999";
  add("run_2");
  const auto current = add("run_3");
  EXPECT_EQ(keep(current, 2'500'000).removed, std::vector<std::string>{"run_2"});
}

TEST_F(FolderLimit, NeverRemovesKeptOrActiveRunsOrOtherFolders) {
  std::ofstream(add("run_1") / "keep") << "";
  const auto recorded = add("run_2");
  const Descriptor lock = lock_run(recorded);
  const auto current = add("run_3");
  std::filesystem::create_directories(config.record.folder / "run_of_mine");
  std::ofstream(config.record.folder / "run_of_mine" / "thesis.txt") << "text";
  const LimitOutcome outcome = keep(current, 1000);
  EXPECT_TRUE(outcome.removed.empty());
  EXPECT_FALSE(outcome.is_kept);
  EXPECT_TRUE(exists(config.record.folder / "run_of_mine" / "thesis.txt"));
}

TEST_F(FolderLimit, CountsNothingToWhichALinkLeads) {
  const auto current = add("run_2");
  std::ofstream(folder / "large") << std::string(2'000'000, '\n');
  std::filesystem::create_symlink(folder / "large", current / "link");
  std::filesystem::create_directories(folder / "elsewhere");
  std::filesystem::rename(add("run_1"), folder / "elsewhere/run_1");
  std::filesystem::create_directory_symlink(folder / "elsewhere/run_1", config.record.folder / "run_1");
  EXPECT_LT(bytes_of_runs(config.record.folder), 1'100'000U);
  EXPECT_TRUE(keep(current, 1'500'000).removed.empty());
  EXPECT_TRUE(keep(current, 1000).removed.empty()) << "to remove a link gives no room";
}

TEST_F(FolderLimit, RemovesTheOldestPartsOfTheActiveRunLast) {
  add("run_1");
  const auto current = add("run_2");
  std::filesystem::copy_file(current / "cycles_0001.csv", current / "cycles_0002.csv");
  std::filesystem::copy_file(current / "cycles_0001.csv", current / "cycles_0003.csv");
  const LimitOutcome outcome = keep(current, 2'500'000);
  EXPECT_EQ(outcome.removed, (std::vector<std::string>{"run_1", "run_2/cycles_0001"}));
  EXPECT_TRUE(outcome.is_kept);
  EXPECT_FALSE(keep(current, 1000).is_kept) << "the part that is being written stays";
  EXPECT_TRUE(exists(current / "cycles_0003.csv"));
}

TEST_F(FolderLimit, EndsTheRecordingIfNothingMoreMayBeRemoved) {
  config.record.limit_GB = 1e-6;
  Recorder recorder = make();
  const auto run = recorder.start();
  std::uint64_t cycle = 0;
  while (recorder.status().is_recording) {
    for (int i = 0; i < 100; ++i) recorder.add(tracked(++cycle));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_NE(recorder.status().failure.find("limit_GB is 1e-06"), std::string::npos)
      << recorder.status().failure;
  recorder.finish();
  EXPECT_TRUE(exists(run / "cycles_0001.csv"));
}

}  // namespace
}  // namespace hystcan::runs::folder_limit_test
