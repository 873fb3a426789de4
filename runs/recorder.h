// Records runs of a controller: one after the other, begun at the start or by a command.
//
// Calls come from three threads: records from the telemetry thread, commands from that of the control
// socket, the end from the main thread. None of them waits for a disk, but for start(), which makes a
// folder, and finish().
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

#include "can/bus_health_log.h"
#include "config/schema/settings.h"
#include "runs/run_writer.h"

namespace hystcan::runs {

class Recorder {
 public:
  /// `info`: of every run (describe()).
  Recorder(const config::Config& config, RunInfo info, RunWriter::Sink sink,
           UtcNow utc_now = std::chrono::system_clock::now);
  ~Recorder() { finish(); }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Begins a run and returns its folder. Throws std::runtime_error if one is under way, or if it cannot be
  /// made.
  std::filesystem::path start();
  /// Ends the run; its last rows are written afterwards. Returns its folder; empty if none is under way.
  std::filesystem::path stop();
  /// Ends the run and waits until all is written.
  void finish();

  void add(const controller::CycleRecord& record);
  void add(const std::vector<config::Change>& changes);

  /// Of the present or the last run.
  RunWriter::Status status() const;

 private:
  std::shared_ptr<RunWriter> writer() const;

  config::Config config_;
  RunInfo info_;
  RunWriter::Sink sink_;
  UtcNow utc_now_;
  mutable std::mutex mutex_;
  std::shared_ptr<RunWriter> writer_;  ///< of the present or the last run
};

}  // namespace hystcan::runs
