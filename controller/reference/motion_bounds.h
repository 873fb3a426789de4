// How far and how fast a shape goes: what a configuration is checked by, before anything moves.
#pragma once

#include "controller/reference/shape.h"

namespace hystcan::controller {

/// Peaks of what is smooth: corners of a ramp or triangle, and steps at once, are not in them. Of a chirp's
/// velocity and acceleration a bound: what they reach where the sine's phase is at its worst while it fades
/// in or out. A multi-sine is sampled, 64 points in its shortest period, to 0.2 % of its amplitudes; a bound,
/// all sines at their worst together, where that would take more than a million points.
struct MotionBounds {
  double lowest_um = 0.0;
  double highest_um = 0.0;
  double peak_slew_um_per_s = 0.0;
  double peak_acceleration_um_per_s2 = 0.0;
};

/// Of a prepared shape.
MotionBounds motion_bounds(const Shape& shape);

}  // namespace hystcan::controller
