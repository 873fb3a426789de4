// Records runs of a controller, one after the other; a run starts with the program or by a command.
//
// Calls arrive from three threads: records from the telemetry thread, commands from the control socket's
// thread, the end from the main thread. No call waits for a disk, except start(), which creates a folder, and
// finish().
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
  /// `info`: the part common to every run (describe()).
  Recorder(const config::Config& config, RunInfo info, RunWriter::Sink sink,
           UtcNow utc_now = std::chrono::system_clock::now);
  ~Recorder() { finish(); }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Starts a run and returns its folder. Throws std::runtime_error if a run is in progress or the folder
  /// can't be created.
  std::filesystem::path start();
  /// Ends the run; its last rows are written later. Returns its folder; empty if no run is in progress.
  std::filesystem::path stop();
  /// Ends the run and waits until everything is written.
  void finish();

  void add(const controller::CycleRecord& record);
  void add(const std::vector<config::Change>& changes);

  /// The status of the present or the last run.
  RunWriter::Status status() const;

 private:
  std::shared_ptr<RunWriter> writer() const;

  config::Config config_;
  RunInfo info_;
  RunWriter::Sink sink_;
  UtcNow utc_now_;
  mutable std::mutex mutex_;
  std::shared_ptr<RunWriter> writer_;  ///< writer of the present or the last run
};

}  // namespace hystcan::runs
