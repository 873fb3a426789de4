// What the page's server itself reads in the controller's rows: changes of state and faults in words, and the times of the
// cycles.
#pragma once

#include <cstddef>
#include <deque>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <vector>

#include "app/page/capture.h"
#include "app/page/timing_histogram.h"

namespace hystcan::app {

class CycleWatch {
 public:
  /// A controller has begun. Throws Error if a column is missing.
  void begin(const nlohmann::json& greeting);
  /// An `event` for the clients, if the row shows one.
  std::optional<nlohmann::json> put(std::span<const double> row);

  /// Keeps an event that no row shows, with the time of the newest row (null before the first); returns it.
  const nlohmann::json& keep(nlohmann::json event);

  const CycleColumns& columns() const { return at_; }
  const std::deque<nlohmann::json>& events() const { return events_; }
  const TimingHistogram& turnaround() const { return turnaround_; }
  const TimingHistogram& lateness() const { return lateness_; }

 private:
  struct Last {
    double state = -1.0, fault = 0.0;
  };

  nlohmann::json event_of(std::span<const double> row) const;

  nlohmann::json greeting_;
  CycleColumns at_{};
  std::vector<Last> last_;  ///< per axis
  double newest_s_ = std::numeric_limits<double>::quiet_NaN();
  std::deque<nlohmann::json> events_;
  TimingHistogram turnaround_, lateness_;
};

}  // namespace hystcan::app
