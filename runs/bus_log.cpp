#include "runs/bus_log.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "base/append_file.h"
#include "base/threads.h"
#include "can/log/candump.h"
#include "can/socketcan/bus_monitor.h"
#include "runs/run_folder.h"

namespace hystcan::runs {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds flush_every{500};

/// Writes bus logs of limited size, one after the other.
class BusLogParts {
 public:
  BusLogParts(std::filesystem::path run, std::uint64_t part_bytes)
      : run_(std::move(run)), part_bytes_(part_bytes) {
    open_next();
  }
  void add(const can::LoggedFrame& frame) {
    if (file_->written_bytes() >= part_bytes_) {
      close();
      open_next();
    }
    file_->add(can::candump_line(frame) + "\n");
  }
  void flush() {
    check(file_->flush());
    if (!file_->is_in_place()) check(std::make_error_code(std::errc::no_such_file_or_directory));
  }
  void close() { check(file_->close()); }

 private:
  void open_next() {
    file_.emplace(run_ / part_name("bus", ++number_, ".log"), AppendFile::Existing::refuse);
  }
  void check(const std::error_code& error) const {
    if (error) throw std::system_error(error, file_->path().string());
  }

  std::filesystem::path run_;
  std::uint64_t part_bytes_;
  unsigned number_ = 0;
  std::optional<AppendFile> file_;
};

}  // namespace

BusLog::BusLog(const std::string& interface, std::filesystem::path run, std::uint64_t part_bytes, Warn warn)
    : warn_(std::move(warn)) {
  auto monitor = std::make_shared<can::BusMonitor>(interface);
  thread_ = std::thread([this, monitor, run = std::move(run), part_bytes] {
    yield_to_the_control_thread();
    try {
      BusLogParts parts(run, part_bytes);
      const can::BusMonitor::Handler add = [&](const can::LoggedFrame& frame) { parts.add(frame); };
      auto flushed = Clock::now();
      while (!ending_) {
        monitor->listen(flush_every / 10, add);
        if (Clock::now() - flushed < flush_every) continue;
        flushed = Clock::now();
        parts.flush();
      }
      monitor->finish(add);
      parts.close();
    } catch (const std::exception& error) {
      warn_(fmt::format("the bus log ended: {}", error.what()));
    }
  });
}

BusLog::~BusLog() {
  ending_ = true;
  thread_.join();
}

}  // namespace hystcan::runs
