#include "controller/telemetry.h"

#include <gtest/gtest.h>

#include <fstream>
#include <latch>
#include <sstream>

#include "tests/support/scratch.h"

namespace hystcan::controller::telemetry_test {
namespace {

CycleRecord numbered(std::uint64_t cycle) {
  CycleRecord record;
  record.cycle = cycle;
  return record;
}

TEST(TelemetryThread, PassesEveryRecordOnInOrder) {
  std::vector<std::uint64_t> seen;
  std::uint64_t dropped = 0;
  {
    TelemetryThread telemetry([&](const CycleRecord& record) { seen.push_back(record.cycle); });
    for (std::uint64_t i = 0; i < 10'000; ++i) telemetry.push(numbered(i));
    dropped = telemetry.dropped();
  }
  ASSERT_EQ(dropped, 0u);
  ASSERT_EQ(seen.size(), 10'000u);
  for (std::uint64_t i = 0; i < seen.size(); ++i) ASSERT_EQ(seen[i], i);
}

TEST(TelemetryThread, DropsAndCountsRecordsWhileTheConsumerIsStuck) {
  std::latch release(1);
  std::size_t consumed = 0;
  constexpr std::size_t pushed = 100'000;  // exceeds the ring's capacity
  std::uint64_t dropped = 0;
  {
    TelemetryThread telemetry([&](const CycleRecord&) {
      release.wait();
      ++consumed;
    });
    for (std::size_t i = 0; i < pushed; ++i) telemetry.push(numbered(i));
    dropped = telemetry.dropped();
    release.count_down();
  }
  EXPECT_GT(dropped, 0u);
  EXPECT_EQ(consumed + dropped, pushed);
}

TEST(CsvLog, WritesARowForEachRecord) {
  const auto file = support::scratch_file("log.csv");
  {
    CsvLog log(file, {"x", "y"});
    CycleRecord record = numbered(7);
    record.time_s = 0.007;
    record.axis = 1;
    record.report.state = AxisState::tracking;
    record.report.reference_um = 3.0;
    record.report.position_um = 2.5;
    record.report.demand_um = 3.25;
    record.report.drive = 10.0;
    record.phases.sample_heard = std::chrono::microseconds(300);
    record.phases.command_sent = std::chrono::microseconds(312);
    log.write(record);
    EXPECT_FALSE(log.close());
  }
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  EXPECT_NE(text.str().find(
                "\n7,0.007000000,y,tracking,none,0,3.000000,2.500000,0.500000,3.250000,10.000000,0.000000,,0,"
                "12.000,,,,0.000000000,0.000000,0.000000,,0,0.000,0.000,300.000,312.000,0.000,0,0,0\n"),
            std::string::npos)
      << text.str();
}

TEST(CsvLog, HasThePlaceInTheScan) {
  const auto file = support::scratch_file("scan.csv");
  {
    CsvLog log(file, {"x"});
    CycleRecord record = numbered(7);
    record.report.state = AxisState::tracking;
    record.report.point.scan = ScanPlace{.frame = 2, .line = 31, .pixel = 5};
    log.write(record);
    record.report.point.scan->pixel = ScanPlace::no_pixel;
    log.write(record);
    record.report.state = AxisState::faulted;
    log.write(record);
    EXPECT_FALSE(log.close());
  }
  std::ifstream stream(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_NE(lines[1].find(",turnaround_us,scan_frame,scan_line,scan_pixel,"), std::string::npos) << lines[1];
  EXPECT_NE(lines[2].find(",0.000,2,31,5,0.0"), std::string::npos) << lines[2];
  EXPECT_NE(lines[3].find(",0.000,2,31,,0.0"), std::string::npos) << lines[3];
  EXPECT_NE(lines[4].find(",0.000,,,,,"), std::string::npos) << lines[4];
}

TEST(CsvLog, ReportsAFullDisk) {
  CsvLog log("/dev/full", {"x"});
  for (int i = 0; i < 10'000; ++i) log.write({});
  EXPECT_NE(log.close().value_or("").find("No space left on device"), std::string::npos);
}

CycleRecord late_by(std::uint64_t cycle, can::Duration late) {
  CycleRecord record = numbered(cycle);
  record.time_s = 1e-3 * static_cast<double>(cycle);
  record.phases.lateness = late;
  return record;
}

TEST(LatenessLog, WritesOneLinePerSecondForAllLateSyncs) {
  using std::chrono::microseconds;
  std::vector<std::string> lines;
  LatenessLog log(microseconds(200),
                  [&](can::BusHealthLog::Level, const std::string& line) { lines.push_back(line); });
  for (std::uint64_t cycle = 1; cycle <= 1500; ++cycle) {
    const auto late = cycle % 10 == 0 ? microseconds(200 + cycle % 400) : microseconds(200);
    log.add(late_by(cycle, late));
    log.add(late_by(cycle, late));  // record of the other axis in the same cycle
  }
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_TRUE(lines[0].starts_with(
      "1 SYNC sent more than 200 us late until 0.010 s after the start, each by at most 210 us"))
      << lines[0];
  EXPECT_TRUE(lines[1].starts_with(
      "98 SYNC sent more than 200 us late until 1.010 s after the start, each by at most 590 us"))
      << lines[1];
}

TEST(LatenessLog, WritesNothingWithoutALimit) {
  LatenessLog log({}, [](can::BusHealthLog::Level, const std::string& line) { FAIL() << line; });
  log.add(late_by(1, std::chrono::seconds(1)));
}

TEST(CsvLog, RefusesAFileThatItCannotWrite) {
  EXPECT_THROW(CsvLog("/nonexistent/folder/x.csv", {"x"}), std::runtime_error);
}

}  // namespace
}  // namespace hystcan::controller::telemetry_test
