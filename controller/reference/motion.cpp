#include "controller/reference/motion.h"

#include <algorithm>

namespace hystcan::controller {

double smooth_step(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
}

Rise smooth_rise(double t_s, double rise_s) {
  const double s = t_s / rise_s;
  if (!(s > 0.0)) return {};
  if (s >= 1.0) return {.value = 1.0};
  return {.value = smooth_step(s),
          .slope_per_s = 30.0 * s * s * (1.0 - s) * (1.0 - s) / rise_s,
          .curvature_per_s2 = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (rise_s * rise_s)};
}

}  // namespace hystcan::controller
