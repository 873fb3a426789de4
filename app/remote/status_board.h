// The newest cycle record of each axis: the telemetry thread writes it, any other thread reads it.
#pragma once

#include <mutex>
#include <vector>

#include "controller/cycle_record.h"

namespace hystcan::app {

class StatusBoard {
 public:
  explicit StatusBoard(std::size_t axes) : newest_(axes) {}

  void put(const controller::CycleRecord& record) {
    const std::scoped_lock lock(mutex_);
    newest_[record.axis] = record;
  }
  /// The newest record of each axis; a default-constructed one if the axis has made none yet.
  std::vector<controller::CycleRecord> newest() const {
    const std::scoped_lock lock(mutex_);
    return newest_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<controller::CycleRecord> newest_;
};

}  // namespace hystcan::app
