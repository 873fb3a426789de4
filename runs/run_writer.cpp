#include "runs/run_writer.h"

#include <fmt/format.h>

#include <chrono>
#include <system_error>
#include <utility>

#include "base/threads.h"
#include "config/files/csv.h"
#include "controller/telemetry.h"

namespace hystcan::runs {
namespace {

using Clock = std::chrono::steady_clock;
using Level = can::BusHealthLog::Level;
constexpr std::chrono::milliseconds write_every{500};
constexpr std::chrono::seconds keep_limit_every{10};

std::uint64_t bytes(double megabytes) { return static_cast<std::uint64_t>(megabytes * 1e6); }

RunInfo started_at(RunInfo info, std::chrono::system_clock::time_point now) {
  info.started = iso_text(now);
  return info;
}

}  // namespace

RunWriter::RunWriter(const config::Config& config, const RunInfo& info, Sink sink, UtcNow utc_now)
    : config_(config.record),
      sink_(std::move(sink)),
      utc_now_(std::move(utc_now)),
      axis_names_(info.axis_names()),
      run_(make_run_folder(std::filesystem::absolute(config_.folder), config.file,
                           started_at(info, utc_now_()), utc_now_())),
      lock_(lock_run(run_)),
      info_(read_run_info(run_)),
      summary_(info.axes.size()) {
  try {
    open_part();
    if (config_.bus_log)
      bus_log_ = std::make_unique<BusLog>(
          config.bus.interface, run_, bytes(config_.part_MB), [this](const std::string& reason) {
            sink_(Level::warning, fmt::format("{}: {}", run_.string(), reason));
          });
  } catch (...) {  // the run could not start: removes its folder
    std::error_code ignored;
    std::filesystem::remove_all(run_, ignored);
    throw;
  }
}

RunWriter::~RunWriter() = default;

void RunWriter::add(const controller::CycleRecord& record) {
  const std::scoped_lock lock(mutex_);
  if (ending_ || closed_ || rows_.size() > most_waiting) {
    if (!ending_) ++status_.rows_lost;
    return;
  }
  append_cycle_row(rows_, record, axis_names_);
  rows_ += '\n';
  ++status_.rows;
  summary_.add(record.axis, record.time_s, record.report.state, record.report.cause,
               record.report.reference_um - record.report.position_um);
}

void RunWriter::add(const config::Change& change) {
  const std::scoped_lock lock(mutex_);
  if (changes_.size() < most_waiting)
    changes_ += fmt::format("{},{},{},{}\n", iso_text(utc_now_()), change.path,
                            config::csv_field(change.from), config::csv_field(change.to));
}

void RunWriter::end() {
  const std::scoped_lock lock(mutex_);
  ending_ = true;
  changed_.notify_all();
}

bool RunWriter::is_closed() const {
  const std::scoped_lock lock(mutex_);
  return closed_;
}

void RunWriter::await() const {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return returned_; });
}

RunWriter::Status RunWriter::status() const {
  const std::scoped_lock lock(mutex_);
  Status status = status_;
  status.is_recording = !closed_;
  status.run = run_;
  return status;
}

void RunWriter::write_until_the_end() {
  yield_to_the_control_thread();
  std::string rows, changes;
  try {
    for (bool is_last = false; !is_last;) {
      {
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, write_every, [this] { return ending_; });
        is_last = ending_;
        std::swap(rows, rows_);
        std::swap(changes, changes_);
      }
      write(rows, changes);
    }
  } catch (const std::exception& error) {
    fail(error.what());
  }
  close();
  const std::scoped_lock lock(mutex_);
  returned_ = true;
  changed_.notify_all();
}

void RunWriter::write(std::string& rows, std::string& changes) {
  if (!changes.empty()) {
    if (!changes_file_) {
      changes_file_ = std::make_unique<AppendFile>(run_ / "changes.csv", AppendFile::Existing::refuse);
      changes_file_->add("time,key,from,to\n");
    }
    changes_file_->add(changes);
    if (const std::error_code error = changes_file_->flush(); error)
      throw std::system_error(error, changes_file_->path().string());
  }
  part_->add(rows);
  if (const std::error_code error = part_->flush(); error)
    throw std::system_error(error, part_->path().string());
  if (!part_->is_in_place()) throw std::runtime_error(part_->path().string() + " was removed");
  rows.clear();
  changes.clear();
  {
    const std::scoped_lock lock(mutex_);
    status_.bytes = closed_bytes_ + part_->written_bytes();
  }
  if (is_part_full()) {
    close_part();
    open_part();
    keep_limit();
  } else if (Clock::now() - limit_kept_ > keep_limit_every) {
    keep_limit();
  }
}

bool RunWriter::is_part_full() const {
  return part_->written_bytes() >= bytes(config_.part_MB) || Clock::now() - part_began_ >= config_.part_time;
}

void RunWriter::open_part() {
  part_ = std::make_unique<AppendFile>(run_ / part_name("cycles", ++part_number_, ".csv"),
                                       AppendFile::Existing::refuse);
  part_began_ = Clock::now();
  std::string header(controller::cycle_units);
  controller::append_cycle_header(header);
  part_->add(header += '\n');
  if (const std::error_code error = part_->flush(); error)
    throw std::system_error(error, part_->path().string());
}

void RunWriter::close_part() {
  part_->sync();
  if (const std::error_code error = part_->close(); error)
    throw std::system_error(error, part_->path().string());
  closed_bytes_ += part_->written_bytes();
}

void RunWriter::keep_limit() {
  limit_kept_ = Clock::now();
  const LimitOutcome outcome = runs::keep_limit(config_.folder, run_, bytes(1e3 * config_.limit_GB));
  for (const std::string& name : outcome.removed)
    sink_(Level::info, fmt::format("{}: limit_GB is {:g}, so {} was removed", config_.folder.string(),
                                   config_.limit_GB, name));
  if (!outcome.is_kept)
    throw std::runtime_error(fmt::format(
        "{}: {:.3g} GB are in use, limit_GB is {:g}, and no more files may be removed: raise limit_GB",
        config_.folder.string(), 1e-9 * static_cast<double>(outcome.bytes), config_.limit_GB));
}

void RunWriter::fail(const std::string& reason) {
  {
    const std::scoped_lock lock(mutex_);
    status_.failure = reason;
    closed_ = true;
    rows_ = {};
  }
  sink_(Level::warning, fmt::format("{}: the recording ended: {}; control continues", run_.string(), reason));
}

void RunWriter::close() {
  bus_log_.reset();
  changes_file_.reset();
  try {
    info_.failure = status().failure;
    if (info_.failure.empty()) close_part();
    part_.reset();  // on a full disk, a deleted file uses its space until the file is closed
    {
      const std::scoped_lock lock(mutex_);
      summary_.put_into(info_);
      info_.rows_lost = status_.rows_lost;
    }
    info_.ended = iso_text(utc_now_());
    write_run_info(run_, info_);
  } catch (const std::exception& error) {
    sink_(Level::warning, fmt::format("{}: cannot be closed: {}", run_.string(), error.what()));
  }
  lock_.reset();
  const std::scoped_lock lock(mutex_);
  closed_ = true;
}

}  // namespace hystcan::runs
