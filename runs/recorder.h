// Records runs of a controller, one after the other. A run starts with the program or by a command.
//
// Three threads call the Recorder: the telemetry thread adds records, the thread of the control socket starts
// and stops runs, and the main thread calls finish(). Only start(), which creates a folder, and finish() wait
// for the disk.
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
  /// `info` is the description that all runs have in common (see describe() in runs/run_folder.h).
  Recorder(const config::Config& config, RunInfo info, RunWriter::Sink sink,
           UtcNow utc_now = std::chrono::system_clock::now);
  ~Recorder() { finish(); }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Starts a run and returns its folder. Throws std::runtime_error if a run is in progress or the folder
  /// can't be created.
  std::filesystem::path start();
  /// Ends the present run without waiting: the last rows are written afterwards. Returns the run's folder, or
  /// an empty path if no run is in progress.
  std::filesystem::path stop();
  /// Ends the present run and waits until all its rows are written.
  void finish();

  void add(const controller::CycleRecord& record);
  void add(const std::vector<config::Change>& changes);

  /// Returns the status of the present run, or of the last run if no run is in progress.
  RunWriter::Status status() const;

 private:
  std::shared_ptr<RunWriter> writer() const;

  config::Config config_;
  RunInfo info_;
  RunWriter::Sink sink_;
  UtcNow utc_now_;
  mutable std::mutex mutex_;
  std::shared_ptr<RunWriter> writer_;  ///< writer of the present or the last run; null before the first run
};

}  // namespace hystcan::runs
