// Decides when the axes begin to track. All axes that are ready begin together. They do not wait for an axis
// that is faulted or offline, and they wait at most `timeout` for an axis that is starting up. An axis that
// becomes ready while others track joins them: the references of all axes count from the same time.
#pragma once

#include <optional>

#include "controller/wired_axis.h"

namespace hystcan::controller {

class TogetherStart {
 public:
  struct Config {
    bool waits = true;        ///< The first axis that is ready waits for the others.
    can::Duration timeout{};  ///< Maximum time for which a ready axis waits for the others.
  };
  explicit TogetherStart(const Config& config) : config_(config) {}

  /// Decides if the axes begin to track in this cycle. Called once per cycle, before the axes are stepped.
  /// `reference_s`: the present reference time.
  void step(const WiredAxes& axes, can::Time now, double reference_s);
  /// Returns the reference time at which the axes began to track. Returns `nullopt` while no axis may begin.
  const std::optional<double>& tracking_since_s() const { return tracking_since_s_; }

 private:
  Config config_;
  /// Time at which the first axis became ready; empty while an axis tracks.
  std::optional<can::Time> ready_since_;
  std::optional<double> tracking_since_s_;
};

}  // namespace hystcan::controller
