// The feed-forward that inverts the plant: PlantInverse in controller/control/plant_inverse.h.
//
// V weighs the reference at whole cycles about the mean delay mu. It is chosen for the position between the samples too:
// with P from the setpoints to the position (held_plant.h), N the notch, d the command delay, theta = w T,
//
//   minimise  integral W(theta) sum_m |delta_m0 - P_m V|^2 dtheta
//   P_m = N(theta) P(i w_m) e^{-i w_m d},    w_m = w + 2 pi m / T,    W = 1 / (theta^2 + theta_0^2)^2
//
// W is that of a triangle. P_m of m != 0 is what rings between the samples, so nothing is inverted that the samples
// alone would show: a mode near half the rate stays. Two conditions hold exactly: gain 1 and mean delay mu, so that a ramp
// is followed without an error.
#pragma once

#include "controller/analysis/linear_loop.h"
#include "controller/control/axis.h"

namespace hystcan::controller {

/// Throws std::invalid_argument where a parameter of the loop is out of range.
PlantInverse::Config design_plant_inverse(const LoopConfig& loop);

/// Sets plant_inverse of the axis, where its delays ask for it; empty otherwise.
void plan_feed_forward(AxisConfig& axis, double rate_Hz);

}  // namespace hystcan::controller
