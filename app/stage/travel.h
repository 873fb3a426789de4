// How far the position of an axis goes during an experiment.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "controller/control/axis.h"

namespace hystcan::app {

/// How far and how fast the position went.
struct Travel {
  double first_um = 0.0, low_um = 0.0, high_um = 0.0;
  double largest_jump_um = 0.0;
  std::optional<double> last_um{};

  void add(const controller::AxisReport& report) {
    if (report.state != controller::AxisState::tracking || report.sample_missing) return;
    const double here = report.position_um;
    if (!last_um) first_um = low_um = high_um = here;
    largest_jump_um = std::max(largest_jump_um, std::abs(here - last_um.value_or(here)));
    low_um = std::min(low_um, here);
    high_um = std::max(high_um, here);
    last_um = here;
  }
};

}  // namespace hystcan::app
