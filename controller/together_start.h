// Decides when the axes begin to track. Those that are ready begin together; none waits for one that is
// faulted or offline, nor longer than `timeout` for one that is not ready. An axis that becomes ready while
// others track joins them: all references count from the same time.
#pragma once

#include <optional>

#include "controller/wired_axis.h"

namespace hystcan::controller {

class TogetherStart {
 public:
  struct Config {
    bool waits = true;        ///< The first axis that is ready waits for the others.
    can::Duration timeout{};  ///< For so long.
  };
  explicit TogetherStart(const Config& config) : config_(config) {}

  /// Called once in a cycle, before the axes are stepped. `reference_s`: the reference time now.
  void step(const WiredAxes& axes, can::Time now, double reference_s);
  /// Of all axes; empty: an axis that is ready does not begin yet.
  const std::optional<double>& tracking_since_s() const { return tracking_since_s_; }

 private:
  Config config_;
  std::optional<can::Time> ready_since_;  ///< Of the first axis that is ready, while none tracks.
  std::optional<double> tracking_since_s_;
};

}  // namespace hystcan::controller
