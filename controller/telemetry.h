// The path of the cycle records from the control thread to all slow tasks: a lock-free ring that a separate
// thread empties.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/append_file.h"
#include "can/bus_health_log.h"
#include "controller/cycle_record.h"

namespace hystcan::controller {

/// Passes cycle records to `consume`, which runs on another thread. push() neither waits nor allocates. If
/// the ring is full, push() drops the record and counts it.
class TelemetryThread {
 public:
  using Consumer = std::function<void(const CycleRecord&)>;

  explicit TelemetryThread(Consumer consume);
  ~TelemetryThread();  ///< consumes the remaining records, then ends the thread

  void push(const CycleRecord& record);
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  void run();

  struct Ring;  // keeps Boost's headers out of this header
  std::unique_ptr<Ring> ring_;
  Consumer consume_;
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

/// Writes cycle records as CSV (controller/cycle_record.h).
class CsvLog {
 public:
  /// Creates the file; replaces an existing one. Throws std::system_error if the file cannot be created.
  CsvLog(const std::filesystem::path& file, std::vector<std::string> axis_names);

  /// Writes a row. A full disk loses rows and does not stop the run.
  void write(const CycleRecord& record);
  /// Closes the file. Returns the reason if rows were lost.
  std::optional<std::string> close();

 private:
  std::vector<std::string> axis_names_;
  AppendFile file_;
  std::string row_;
};

/// Logs SYNCs that were sent more than `warn` after their deadline, at most one line per second. Runs on the
/// telemetry thread. Logs nothing if `warn` is zero.
class LatenessLog {
 public:
  LatenessLog(can::Duration warn, can::BusHealthLog::Sink sink) : warn_(warn), sink_(std::move(sink)) {}

  void add(const CycleRecord& record);

 private:
  can::Duration warn_;
  can::BusHealthLog::Sink sink_;
  can::RateLimit limit_;
  std::uint64_t last_cycle_ = 0;
  can::Duration worst_{};  ///< largest lateness since the last logged line
};

}  // namespace hystcan::controller
