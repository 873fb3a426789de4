#include "controller/telemetry.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <boost/lockfree/spsc_queue.hpp>
#include <cerrno>
#include <chrono>
#include <utility>

#include "base/threads.h"
#include "controller/cycle_record.h"

namespace hystcan::controller {
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
    : axis_names_(std::move(axis_names)), file_(file, AppendFile::Existing::replace) {
  row_ = cycle_units;
  append_cycle_header(row_);
  file_.add(row_ += '\n');
}

void CsvLog::write(const CycleRecord& record) {
  row_.clear();
  append_cycle_row(row_, record, axis_names_);
  file_.add(row_ += '\n');
}

std::optional<std::string> CsvLog::close() {
  file_.close();
  if (!file_.error()) return std::nullopt;
  return file_.error_text() + "; later rows are lost";
}

void LatenessLog::add(const CycleRecord& record) {
  if (warn_ == can::Duration::zero()) return;
  const bool is_new = record.cycle != last_cycle_;  // each cycle has one record per axis
  last_cycle_ = record.cycle;
  const can::Duration late = record.phases.lateness;
  const bool counts = is_new && late > warn_;
  if (counts) worst_ = std::max(worst_, late);
  const auto times = limit_.add(counts ? 1 : 0, record.time_s);
  if (!times) return;
  const auto us = [](can::Duration d) { return std::chrono::duration<double, std::micro>(d).count(); };
  sink_(can::BusHealthLog::Level::warning,
        fmt::format(
            "{} SYNC sent more than {:g} us late until {:.3f} s after the start, each by at most {:.0f} us: "
            "run hystcan doctor",
            *times, us(warn_), record.time_s, us(std::exchange(worst_, can::Duration::zero()))));
}

}  // namespace hystcan::controller
