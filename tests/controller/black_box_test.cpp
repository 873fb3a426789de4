#include "controller/black_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "controller/cycle_record.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/scratch.h"

namespace hystcan::controller::black_box_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// A temporary folder, and a black box of 20 cycles, 5 of them after the fault.
class BlackBoxes : public testing::Test {
 protected:
  BlackBox make(unsigned files = 50) { return make(folder, files); }
  BlackBox make(const std::filesystem::path& of_files, unsigned files) {
    return {{.folder = of_files, .files = files, .cycles = 20, .cycles_after = 5},
            {"x", "y 1"},
            [this](can::BusHealthLog::Level level, const std::string& line) {
              (level == can::BusHealthLog::Level::warning ? warnings : infos).push_back(line);
            },
            [this] { return now; }};
  }

  static CycleRecord record(std::uint64_t cycle, AxisState state, std::size_t axis = 0) {
    CycleRecord made;
    made.cycle = cycle;
    made.time_s = 1e-3 * static_cast<double>(cycle);
    made.axis = axis;
    made.report.state = state;
    made.report.cause = state == AxisState::faulted ? Cause::following_error : Cause::none;
    made.report.position_um = 100.0 + static_cast<double>(cycle);
    return made;
  }
  static void run(BlackBox& box, std::uint64_t first, std::uint64_t last, AxisState state) {
    for (std::uint64_t cycle = first; cycle <= last; ++cycle) box.add(record(cycle, state));
  }

  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
  }
  /// Returns the rows without comments and header.
  std::vector<std::string> rows(const std::string& name) const {
    std::ifstream stream(folder / name);
    std::vector<std::string> result;
    for (std::string line; std::getline(stream, line);)
      if (line[0] != '#' && !line.starts_with("cycle,")) result.push_back(line);
    return result;
  }
  /// Returns the field of the row in that column.
  static std::string cell(const std::string& row, std::string_view column) {
    std::string header;
    append_cycle_header(header);
    std::istringstream names(header + ",next_position_um"), fields(row);
    std::string name, field;
    while (std::getline(names, name, ',')) {
      field.clear();
      std::getline(fields, field, ',');
      if (name == column) return field;
    }
    ADD_FAILURE() << "no column " << column;
    return {};
  }

  const support::ScratchFolder scratch;
  const std::filesystem::path& folder = scratch.path();
  /// 2026-11-21 22:19:23.456 UTC
  std::chrono::system_clock::time_point now{milliseconds(1'795'299'563'456)};
  std::vector<std::string> warnings;
  std::vector<std::string> infos;
};

TEST_F(BlackBoxes, HoldTheCyclesBeforeTheFaultAndFiveAfterIt) {
  BlackBox box = make();
  run(box, 1, 100, AxisState::tracking);
  EXPECT_TRUE(files().empty()) << "there was no fault";
  run(box, 101, 105, AxisState::faulted);
  EXPECT_TRUE(files().empty()) << "the cycles after the fault are still missing";
  run(box, 106, 200, AxisState::faulted);
  ASSERT_EQ(files(), std::vector<std::string>{"blackbox_20261121T221923.456Z_x.csv"});
  const auto lines = rows(files()[0]);
  ASSERT_EQ(lines.size(), 20u);
  EXPECT_EQ(cell(lines.front(), "cycle"), "87");
  EXPECT_EQ(cell(lines[13], "fault"), "none");
  EXPECT_EQ(cell(lines[14], "cycle"), "101");
  EXPECT_EQ(cell(lines[14], "fault"), "following error");
  EXPECT_EQ(cell(lines.back(), "cycle"), "106");
  EXPECT_TRUE(warnings.empty());
}

TEST_F(BlackBoxes, HaveARowForEachCycle) {
  BlackBox box = make();
  CycleRecord one = record(7, AxisState::tracking);
  one.report.point.segment = 2;
  one.report.reference_um = 3.0;
  one.report.position_um = 2.5;
  one.report.demand_um = 3.25;
  one.report.drive = 10.0;
  one.report.limits = limit::slew;
  one.amplifier_output = 9.5;
  one.phases = {.period = microseconds(1001),
                .lateness = microseconds(2),
                .sample_heard = microseconds(300),
                .command_sent = microseconds(312),
                .execution = std::chrono::nanoseconds(450)};
  one.report.learning = {.state = LearningState::learning, .correction_um = 0.125};
  one.counters = {.cycles = 7, .missed_cycles = 1, .missing_samples = 2, .late_samples = 3};
  box.add(one);
  CycleRecord lost = record(8, AxisState::tracking);
  lost.report.sample_missing = true;
  box.add(lost);
  box.add(record(9, AxisState::faulted));
  box.finish();
  ASSERT_EQ(files().size(), 1u);
  const auto lines = rows(files()[0]);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_TRUE(lines[0].starts_with(
      "7,0.007000000,x,tracking,none,2,3.000000,2.500000,0.500000,3.250000,10.000000,9.500000,slew,0,"))
      << lines[0];
  EXPECT_TRUE(lines[0].ends_with(",1001.000,2.000,300.000,312.000,0.450,1,2,3,"))
      << lines[0] << ": cycle 8 has no sample for command 7";
  EXPECT_EQ(cell(lines[0], "learnt_um"), "0.125000");
  EXPECT_EQ(cell(lines[1], "next_position_um"), "109.000000")
      << "the sample of cycle 9 is the response to command 8";
  EXPECT_EQ(cell(lines[1], "sample_heard_us"), "") << "no sample was received";
  EXPECT_EQ(cell(lines[1], "learnt_um"), "") << "nothing is learnt";
}

TEST_F(BlackBoxes, AreWrittenOnceAtTheEndOfTheRun) {
  BlackBox box = make();
  run(box, 1, 3, AxisState::tracking);
  run(box, 4, 5, AxisState::faulted);
  box.finish();
  ASSERT_EQ(files().size(), 1u);
  EXPECT_EQ(rows(files()[0]).size(), 5u);
  box.finish();
  EXPECT_EQ(files().size(), 1u) << "finish() writes each file only once";
}

TEST_F(BlackBoxes, AreWrittenForEachFaultEvenInQuickSuccession) {
  BlackBox box = make();
  run(box, 1, 3, AxisState::tracking);
  run(box, 4, 5, AxisState::faulted);
  run(box, 6, 6, AxisState::waiting);  // cleared
  now += milliseconds(3);
  run(box, 7, 30, AxisState::faulted);
  ASSERT_EQ(files(), (std::vector<std::string>{"blackbox_20261121T221923.456Z_x.csv",
                                               "blackbox_20261121T221923.459Z_x.csv"}));
  EXPECT_EQ(rows(files()[0]).size(), 6u);
  EXPECT_EQ(cell(rows(files()[1]).back(), "cycle"), "12");
}

TEST_F(BlackBoxes, AreWrittenForEveryAxisOnRequest) {
  BlackBox box = make();
  run(box, 1, 3, AxisState::tracking);
  box.add(record(3, AxisState::tracking, 1));
  box.request();
  run(box, 4, 6, AxisState::tracking);
  EXPECT_EQ(files(), (std::vector<std::string>{"blackbox_20261121T221923.456Z_x.csv",
                                               "blackbox_20261121T221923.456Z_y_1.csv"}));
}

TEST_F(BlackBoxes, NeverReplaceAnExistingFile) {
  std::ofstream(folder / "blackbox_20261121T221923.456Z_x.csv") << "precious";
  BlackBox box = make();
  run(box, 4, 30, AxisState::faulted);
  EXPECT_EQ(rows("blackbox_20261121T221923.456Z_x.csv"), std::vector<std::string>{"precious"});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("File exists"), std::string::npos) << warnings[0];
}

TEST_F(BlackBoxes, DoNotExceedTheAllowedNumberOfFiles) {
  BlackBox box = make(2);
  for (std::uint64_t i = 0; i < 4; ++i) {
    run(box, 10 * i, 10 * i + 1, AxisState::tracking);
    run(box, 10 * i + 2, 10 * i + 9, AxisState::faulted);
    now += milliseconds(1);
  }
  EXPECT_EQ(files().size(), 2u);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("the maximum is 2"), std::string::npos) << warnings[0];
}

TEST_F(BlackBoxes, WarnAtStartAndAtAFaultIfTheFolderIsMissing) {
  std::filesystem::remove_all(folder);
  BlackBox box = make();
  ASSERT_EQ(warnings.size(), 1u);
  run(box, 4, 30, AxisState::faulted);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[1].find("No such file or directory"), std::string::npos) << warnings[1];
}

TEST_F(BlackBoxes, CreateADefaultFolderAtTheFirstFault) {
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder);
  BlackBox box = make({}, 50);
  std::filesystem::current_path(before);
  EXPECT_TRUE(files().empty());
  run(box, 4, 30, AxisState::faulted);
  EXPECT_EQ(files(), std::vector<std::string>{"hystcan-blackbox"});
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / "hystcan-blackbox"), {}), 1);
  EXPECT_TRUE(warnings.empty());
}

TEST_F(BlackBoxes, WarnAndLeaveNoFileIfTheDiskIsFull) {
  BlackBox box = make();
  {
    const support::FileSizeLimit full(1024);
    run(box, 4, 30, AxisState::faulted);
  }
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("no black box"), std::string::npos) << warnings[0];
  EXPECT_TRUE(files().empty()) << "an unfinished file remains";
}

}  // namespace
}  // namespace hystcan::controller::black_box_test
