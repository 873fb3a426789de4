// The newest cycle record of each axis: the telemetry thread writes it, any other thread reads it.
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <vector>

#include "controller/cycle_record.h"

namespace hystcan::app {

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

}  // namespace hystcan::app
