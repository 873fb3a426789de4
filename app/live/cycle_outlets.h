// All that a controller's cycle records feed for those who command and watch it: the newest of each axis, the
// stream, and the recording of runs.
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

/// The newest cycle record of each axis: the telemetry thread writes it, any other thread reads it.
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
  /// The newest record with an event of a node; none yet: empty.
  std::optional<controller::CycleRecord> last_event() const {
    const std::scoped_lock lock(mutex_);
    return last_event_;
  }
  /// The time since the last record was put, or since the start if there is none.
  double age_s(Clock::time_point now = Clock::now()) const {
    const std::scoped_lock lock(mutex_);
    return std::chrono::duration<double>(now - put_).count();
  }
  /// The newest record of each axis; a default-constructed one if the axis has made none yet.
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
  /// More never waits: a batch is taken every 20 ms.
  static std::size_t samples_of_a_second(const config::Config& config) {
    return config.axes.size() * static_cast<std::size_t>(std::max(config.controller.rate_Hz, 1.0));
  }
};

}  // namespace hystcan::app
