// Receives the controller's cycle records and passes each one to three consumers: the board with the newest
// record of each axis, the sample stream, and the recorder of runs.
#pragma once

#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>
#include <vector>

#include "app/live/sample_stream.h"
#include "app/live/samples.h"
#include "config/schema/config.h"
#include "controller/cycle_record.h"
#include "runs/recorder.h"

namespace hystcan::app {

/// Holds the newest cycle record of each axis. The telemetry thread writes it; any other thread may read it.
class StatusBoard {
 public:
  using Clock = std::chrono::steady_clock;

  explicit StatusBoard(std::size_t axes, Clock::time_point now = Clock::now()) : newest_(axes), put_(now) {}

  void put(const controller::CycleRecord& record, Clock::time_point now = Clock::now()) {
    const std::scoped_lock lock(mutex_);
    newest_[record.axis] = record;
    if (record.event) last_event_ = record;
    put_ = now;
  }
  /// Returns the newest cycle record that contains a node event; nullopt if there is none.
  std::optional<controller::CycleRecord> last_event() const {
    const std::scoped_lock lock(mutex_);
    return last_event_;
  }
  /// Returns the time in s since the last record; if no record has arrived, the time since the start.
  double age_s(Clock::time_point now = Clock::now()) const {
    const std::scoped_lock lock(mutex_);
    return std::chrono::duration<double>(now - put_).count();
  }
  /// Returns the newest record of each axis; a default-constructed record if the axis has none yet.
  std::vector<controller::CycleRecord> newest() const {
    const std::scoped_lock lock(mutex_);
    return newest_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<controller::CycleRecord> newest_;
  std::optional<controller::CycleRecord> last_event_;
  Clock::time_point put_;
};

struct CycleOutlets {
  CycleOutlets(const config::Config& config, runs::RunInfo info, const can::BusHealthLog::Sink& sink)
      : board(config.axes.size()),
        samples(streamed_columns.size(), samples_of_a_second(config)),
        recorder(config, std::move(info), sink) {}

  void put(const controller::CycleRecord& record) {
    board.put(record);
    if (samples.is_listening()) samples.put(sample_of(record));
    recorder.add(record);
  }

  StatusBoard board;
  SampleBoard samples;
  runs::Recorder recorder;

 private:
  /// Returns the number of samples of all axes in one second. This is the capacity of the sample board. The
  /// stream empties the board every 20 ms, so the board does not become full.
  static std::size_t samples_of_a_second(const config::Config& config) {
    return config.axes.size() * static_cast<std::size_t>(std::max(config.controller.rate_Hz, 1.0));
  }
};

}  // namespace hystcan::app
