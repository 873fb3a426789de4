// The black box keeps the last cycles of each axis in memory. When an axis faults, the black box writes the
// cycles of this axis as CSV. They show the cause and the consequences of the fault.
//
// The black box runs on the telemetry thread and reads the cycle records, so it costs the control thread
// nothing. Each fault has its own file, blackbox_20261121T221923.456Z_x.csv, named after the time (UTC) and
// the axis. Files are never overwritten or removed. If the folder already contains the allowed number of
// files, no more files are written, because the first fault explains the most. A refused file, a full disk
// and a missing folder cause warnings; the run continues.
//
// A row is a cycle n: SYNC, sample, command. The column next_position_um is the sample of cycle n+1, the
// first sample that command n can influence. It is empty if cycle n+1 has no sample or was not recorded. The
// other columns are described in controller/cycle_record.h.
#pragma once

#include <atomic>
#include <boost/circular_buffer.hpp>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/bus_health_log.h"
#include "controller/cycle_record.h"

namespace hystcan::controller {

class BlackBox {
 public:
  struct Config {
    /// Folder of the files. Empty: hystcan-blackbox in the working directory, created with the first file.
    std::filesystem::path folder;
    unsigned files = 50;             ///< maximum number of files of all runs in the folder; 0: writes none
    std::size_t cycles = 10'000;     ///< number of cycles that are kept for each axis
    std::size_t cycles_after = 100;  ///< number of kept cycles that follow the fault
  };
  using Sink = can::BusHealthLog::Sink;
  using UtcNow = std::function<std::chrono::system_clock::time_point()>;

  /// Warns immediately if the folder would not accept a file.
  BlackBox(const Config& config, std::vector<std::string> axis_names, Sink sink,
           UtcNow utc_now = std::chrono::system_clock::now);

  void add(const CycleRecord& record);
  /// Writes the file of each fault for which fewer than `cycles_after` later cycles have been recorded so
  /// far. Called when no more records follow.
  void finish();
  /// Requests a file of every axis, which is written with the next record. May be called from any thread.
  void request() { requested_ = true; }

 private:
  struct Box {
    std::string name;
    boost::circular_buffer<CycleRecord> ring;  ///< the last cycles, oldest first
    bool faulted = false;
    std::size_t cycles_to_go = 0;  ///< cycles until the file is written; 0: no file is due
    std::string reason;
    std::chrono::system_clock::time_point faulted_at;
  };

  void note_fault(Box& box, const CycleRecord& record);
  void write(Box& box, std::string_view reason, std::chrono::system_clock::time_point when);
  /// Returns the reason why no file may be added to the folder; `nullopt` if a file may be added.
  std::optional<std::string> reason_against_writing() const;
  std::optional<std::string> reason_against_the_folder() const;
  std::filesystem::path file_for(const Box& box, std::chrono::system_clock::time_point when) const;

  Config config_;
  bool makes_folder_;
  std::vector<std::string> names_;
  Sink sink_;
  UtcNow utc_now_;
  std::vector<Box> boxes_;
  std::atomic<bool> requested_{false};
};

}  // namespace hystcan::controller
