#include "controller/reference/handover.h"

#include <algorithm>

namespace hystcan::controller {

double Handover::value_um(double t_s) const { return at(t_s).value_um; }

Motion Handover::at(double t_s) const {
  if (t_s < lead_s_) {
    const double place = std::max(0.0, t_s / lead_s_) * lead_intervals;
    const std::size_t i = std::min(static_cast<std::size_t>(place), lead_intervals - 1);
    const double rise_um = lead_[i + 1] - lead_[i];
    return {.value_um = lead_[i] + (place - static_cast<double>(i)) * rise_um,
            .velocity_um_per_s = rise_um * lead_intervals / lead_s_};
  }
  t_s -= lead_s_;
  if (t_s < braking_.duration_s()) return braking_.at(t_s);
  return onward_.at(t_s - braking_.duration_s());
}

}  // namespace hystcan::controller
