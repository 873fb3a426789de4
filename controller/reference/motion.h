// Position, velocity and acceleration at one moment, and the smooth step that brings them from rest to rest.
#pragma once

namespace hystcan::controller {

struct Motion {
  double value_um = 0.0;
  double velocity_um_per_s = 0.0;
  double acceleration_um_per_s2 = 0.0;
};

/// The smooth step (least jerk), 0 for s <= 0 and 1 for s >= 1:  10 s^3 - 15 s^4 + 6 s^5
/// Its greatest slope is 15/8, its greatest curvature 10/sqrt(3).
double smooth_step(double s);
inline constexpr double smooth_step_peak_slope = 1.875;
inline constexpr double smooth_step_peak_curvature = 5.773502691896258;

/// The smooth step from 0 to 1 in `rise_s`; its derivatives in 1/s and 1/s^2.
struct Rise {
  double value = 0.0;
  double slope_per_s = 0.0;
  double curvature_per_s2 = 0.0;
};
Rise smooth_rise(double t_s, double rise_s);

}  // namespace hystcan::controller
