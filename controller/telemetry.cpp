#include "controller/telemetry.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <boost/lockfree/spsc_queue.hpp>
#include <cerrno>
#include <chrono>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace hystcan::controller {
namespace {

constexpr const char* csv_header =
    "# drive and amplifier_output in the axis's drive unit; error = reference - position\n"
    "cycle,time_s,axis,state,fault,segment,reference_um,position_um,error_um,demand_um,"
    "drive,amplifier_output,limits,sample_missing,turnaround_us,scan_frame,scan_line,scan_pixel\n";

/// The last three columns; empty beside the lines of a scan, the pixel also in its turnarounds.
void append_scan(fmt::memory_buffer& line, const std::optional<ScanPlace>& scan) {
  const auto out = std::back_inserter(line);
  if (scan)
    fmt::format_to(out, "{},{},", scan->frame, scan->line);
  else
    fmt::format_to(out, ",,");
  if (scan && scan->pixel != ScanPlace::no_pixel) fmt::format_to(out, "{}", scan->pixel);
  fmt::format_to(out, "\n");
}

}  // namespace

void yield_to_the_control_thread() {
  const sched_param ordinary{.sched_priority = 0};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 10);
}

struct TelemetryThread::Ring {
  static constexpr std::size_t capacity = 16384;
  boost::lockfree::spsc_queue<CycleRecord, boost::lockfree::capacity<capacity>> records;
};

TelemetryThread::TelemetryThread(Consumer consume)
    : ring_(std::make_unique<Ring>()), consume_(std::move(consume)), thread_([this] { run(); }) {}

TelemetryThread::~TelemetryThread() {
  ending_ = true;
  thread_.join();
}

void TelemetryThread::push(const CycleRecord& record) {
  if (!ring_->records.push(record)) dropped_.fetch_add(1, std::memory_order_relaxed);
}

void TelemetryThread::run() {
  yield_to_the_control_thread();
  while (true) {
    const bool last_round = ending_;
    ring_->records.consume_all(consume_);
    if (last_round) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

CsvLog::CsvLog(const std::filesystem::path& file, std::vector<std::string> axis_names)
    : axis_names_(std::move(axis_names)), rows_(file, csv_header) {}

void CsvLog::write(const CycleRecord& record) {
  const AxisReport& report = record.report;
  const bool tracking = report.state == AxisState::tracking;
  fmt::memory_buffer line;
  fmt::format_to(std::back_inserter(line), "{},{:.9f},{},{},{},", record.cycle, record.time_s,
                 axis_names_[record.axis], to_string(report.state), to_string(report.cause));
  if (tracking)
    fmt::format_to(std::back_inserter(line), "{},{:.6f},{:.6f},{:.6f},{:.6f},", report.point.segment,
                   report.reference_um, report.position_um, report.reference_um - report.position_um,
                   report.demand_um);
  else
    fmt::format_to(std::back_inserter(line), ",,{:.6f},,,", report.position_um);
  fmt::format_to(std::back_inserter(line), "{:.6f},{:.6f},{},{},{:.3f},", report.drive,
                 record.amplifier_output, limits_to_string(report.limits), report.sample_missing ? 1 : 0,
                 std::chrono::duration<double, std::micro>(record.turnaround).count());
  append_scan(line, tracking ? report.point.scan : std::nullopt);
  rows_.write({line.data(), line.size()});
}

void LatenessLog::add(const CycleRecord& record) {
  if (warn_ == can::Duration::zero()) return;
  const bool is_new = record.cycle != last_cycle_;  // each cycle has a record for each axis
  last_cycle_ = record.cycle;
  const can::Duration late = record.phases.lateness;
  const bool counts = is_new && late > warn_;
  if (counts) worst_ = std::max(worst_, late);
  const auto times = limit_.add(counts ? 1 : 0, record.time_s);
  if (!times) return;
  const auto us = [](can::Duration d) { return std::chrono::duration<double, std::micro>(d).count(); };
  sink_(can::BusHealthLog::Level::warning,
        fmt::format("{} SYNC more than {:g} us late until {:.3f} s, worst {:.0f} us: see hystcan doctor",
                    *times, us(warn_), record.time_s, us(std::exchange(worst_, can::Duration::zero()))));
}

}  // namespace hystcan::controller
