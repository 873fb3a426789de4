// Writes one run to the disk in a thread of its own, so that no other thread waits for the disk.
//
//   telemetry thread ── add() ──▶ text in memory (bounded) ── every half second ──▶ cycles_0001.csv
//
// If the program is killed (SIGKILL), only the rows of the last half second are lost. If the disk is too
// slow, rows are lost and counted. If the disk is full or removed, the recording ends. The status has the
// reason, and run.json has it, too, if it can still be written.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/append_file.h"
#include "can/bus_health_log.h"
#include "config/schema/config.h"
#include "config/schema/settings.h"
#include "controller/cycle_record.h"
#include "runs/bus_log.h"
#include "runs/run_folder.h"
#include "runs/run_info.h"
#include "runs/run_summary.h"

namespace hystcan::runs {

class RunWriter {
 public:
  using Sink = can::BusHealthLog::Sink;
  /// Maximum size of the rows in memory that wait to be written, bytes. Further rows are lost.
  static constexpr std::size_t most_waiting = 16 << 20;

  struct Status {
    bool is_recording = false;
    std::filesystem::path run{};  ///< folder of the run; empty: no run was recorded yet
    std::uint64_t rows = 0;
    std::uint64_t rows_lost = 0;
    std::uint64_t bytes = 0;  ///< total size of the run's CSVs
    std::string failure{};    ///< reason why the recording failed; empty: the recording did not fail
  };

  /// Creates the folder of the run and its first CSV. Throws std::system_error,
  /// std::filesystem::filesystem_error or RunError if this fails.
  RunWriter(const config::Config& config, const RunInfo& info, Sink sink, UtcNow utc_now);
  ~RunWriter();
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  const std::filesystem::path& run() const { return run_; }

  /// Adds a row of cycles_*.csv or of changes.csv, without waiting for the disk.
  void add(const controller::CycleRecord& record);
  void add(const config::Change& change);
  /// Writes the rows to the disk until end() is called. The owner calls this function once, on a thread of
  /// its own.
  void write_until_the_end();
  void end();
  /// Returns true if the run has ended and is completely written, or if the recording failed.
  bool is_closed() const;
  /// Waits until write_until_the_end() has returned.
  void await() const;
  Status status() const;

 private:
  void open_part();
  void close_part();
  void write(std::string& rows, std::string& changes);
  bool is_part_full() const;
  void keep_limit();
  void fail(const std::string& reason);
  void close();

  config::RecordConfig config_;
  Sink sink_;
  UtcNow utc_now_;
  std::vector<std::string> axis_names_;
  std::filesystem::path run_;
  std::optional<Descriptor> lock_;  ///< lock on the run's folder, held until the run is closed
  RunInfo info_;

  // Only the writing thread uses the members below, up to `mutex_`.
  std::unique_ptr<AppendFile> part_, changes_file_;
  unsigned part_number_ = 0;
  std::uint64_t closed_bytes_ = 0;
  std::chrono::steady_clock::time_point part_began_, limit_kept_;
  std::unique_ptr<BusLog> bus_log_;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::string rows_, changes_;  ///< lines of cycles_*.csv and changes.csv that wait to be written
  RunSummary summary_;
  Status status_;
  bool ending_ = false;
  bool closed_ = false;
  bool returned_ = false;
};

}  // namespace hystcan::runs
