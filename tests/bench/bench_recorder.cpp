// Records 8 axes at 4 kHz and measures the cost for the control thread and the machine, and lost rows.
//
//   bench_recorder [SECONDS [FOLDER]]      default 20 s, in the temporary folder
//
// A producer, instead of the control thread, pushes the records of a cycle, then sleeps until the next one.
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include "config/schema/config.h"
#include "controller/telemetry.h"
#include "runs/recorder.h"
#include "runs/run_folder.h"
#include "tests/bench/budgets.h"
#include "tests/bench/short_run.h"

namespace {

using namespace hystcan;
using Clock = std::chrono::steady_clock;
using std::chrono::nanoseconds;

constexpr std::size_t axes = 8;
constexpr auto period = std::chrono::microseconds(250);
constexpr double short_s = 0.5;  ///< short enough for the ring to hold all rows, so that a busy machine loses
                                 ///< none

controller::CycleRecord record_of(std::uint64_t cycle, std::size_t axis) {
  controller::CycleRecord record;
  record.cycle = cycle;
  record.time_s = 250e-6 * static_cast<double>(cycle);
  record.axis = axis;
  record.report.state = controller::AxisState::tracking;
  record.report.reference_um = 10.0 + 1e-4 * static_cast<double>(cycle % 50'000);
  record.report.position_um = record.report.reference_um - 0.0123;
  record.report.drive = 48.31 + 1e-5 * static_cast<double>(cycle % 50'000);
  return record;
}

double process_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Returns the nanoseconds for each record of a whole cycle.
template <class Push>
double timed(const std::vector<controller::CycleRecord>& records, const Push& push) {
  const auto begin = Clock::now();
  for (const auto& record : records) push(record);
  return static_cast<double>(nanoseconds(Clock::now() - begin).count()) / static_cast<double>(records.size());
}

config::Config eight_axes(const std::filesystem::path& folder) {
  config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  config.axes.resize(1);
  config.axes.resize(axes, config.axes.front());
  for (std::size_t i = 0; i < axes; ++i) config.axes[i].wire.name = fmt::format("axis{}", i);
  config.record.folder = folder;
  return config;
}

}  // namespace

int main(int argc, char** argv) {
  bench::Budgets budgets("bench_recorder");
  const double seconds = argc > 1 ? std::atof(argv[1]) : bench::full_or_short(20.0, short_s);
  const std::filesystem::path folder =
      argc > 2 ? argv[2] : std::filesystem::temp_directory_path() / "hystcan-bench-recorder";
  const config::Config config = eight_axes(folder);
  runs::Recorder recorder(
      config, runs::describe(config, {}, "bench"),
      [](can::BusHealthLog::Level, const std::string& line) { fmt::print("{}\n", line); });
  const std::filesystem::path run = recorder.start();

  const double cpu_before_s = process_cpu_s();
  const auto began = Clock::now();
  std::vector<double> push_ns, copy_ns;
  std::uint64_t cycles = 0, dropped = 0;
  {
    auto telemetry = std::make_unique<controller::TelemetryThread>(
        [&](const controller::CycleRecord& record) { recorder.add(record); });
    std::vector<controller::CycleRecord> records(axes), copies(axes);
    for (auto next = began; Clock::now() - began < std::chrono::duration<double>(seconds); next += period) {
      std::this_thread::sleep_until(next);
      ++cycles;
      for (std::size_t axis = 0; axis < axes; ++axis) records[axis] = record_of(cycles, axis);
      std::size_t at = 0;
      copy_ns.push_back(timed(records, [&](const controller::CycleRecord& record) {
        std::memcpy(&copies[at++], &record, sizeof record);
        asm volatile("" ::: "memory");
      }));
      push_ns.push_back(
          timed(records, [&](const controller::CycleRecord& record) { telemetry->push(record); }));
    }
    dropped = telemetry->dropped();
  }
  const double lasted_s = std::chrono::duration<double>(Clock::now() - began).count();
  recorder.finish();
  const double cpu_s = process_cpu_s() - cpu_before_s;

  const auto median = [](std::vector<double>& values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
  };
  const runs::RunWriter::Status status = recorder.status();
  const double push = median(push_ns), copy = median(copy_ns);
  const std::uint64_t lost = dropped + status.rows_lost;
  fmt::print("{} axes at {:.0f} Hz for {:.1f} s: {} rows\n", axes, 1e6 / static_cast<double>(period.count()),
             lasted_s, status.rows);
  fmt::print("a record of {} bytes; {:.2f} times as long as a copy\n", sizeof(controller::CycleRecord),
             push / copy);
  fmt::print("rows lost: {} in the ring, {} at the disk\n", dropped, status.rows_lost);
  fmt::print("{:.1f} bytes per row, {:.1f} MB/s, {:.0f} % of a processor with the producer\n",
             static_cast<double>(status.bytes) / static_cast<double>(status.rows),
             1e-6 * static_cast<double>(status.bytes) / lasted_s, 100.0 * cpu_s / lasted_s);
  std::fflush(stdout);
  budgets.print("control thread, ns a record", push, {60.0});
  budgets.computed("rows lost", static_cast<double>(axes * cycles - status.rows + lost), {});
  std::filesystem::remove_all(run);
  return budgets.status();
}
