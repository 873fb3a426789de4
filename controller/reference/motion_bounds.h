// How far and how fast a shape goes. A configuration is checked by these bounds before anything moves.
#pragma once

#include "controller/reference/shape.h"

namespace hystcan::controller {

/// Peaks of the smooth parts: the corners of a ramp or triangle and the jumps of a step do not count.
/// Chirp: velocity and acceleration are an upper bound, for the worst phase of the sine during the fades.
/// Multi-sine: sampled with 64 points per shortest period, to 0.2 % of its amplitudes; where this takes more
/// than a million points, an upper bound, for all sines at their worst phase at the same time.
struct MotionBounds {
  double lowest_um = 0.0;
  double highest_um = 0.0;
  double peak_slew_um_per_s = 0.0;
  double peak_acceleration_um_per_s2 = 0.0;
};

/// Bounds of a prepared shape.
MotionBounds motion_bounds(const Shape& shape);

}  // namespace hystcan::controller
