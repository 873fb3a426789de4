// Designs the feed-forward that inverts the plant: PlantInverse in controller/control/plant_inverse.h.
//
// V weights the reference at whole cycles around the mean delay mu. The design includes the position between
// the samples. With P from the setpoints to the position (linear_loop.h), N the notch, d the command delay
// and theta = w T:
//
//   minimise  integral W(theta) sum_m |delta_m0 - P_m V|^2 dtheta
//   P_m = N(theta) P(i w_m) e^{-i w_m d},    w_m = w + 2 pi m / T,    W = 1 / (theta^2 + theta_0^2)^2
//
// W is the spectrum of a triangle. P_m with m != 0 is the ringing between the samples. The design therefore
// does not invert a mode near half the rate, although the samples alone would allow it. Two conditions hold
// exactly: gain 1 and mean delay mu, so that a ramp is followed without an error.
#pragma once

#include <functional>
#include <optional>

#include "controller/analysis/linear_loop.h"
#include "controller/control/axis.h"
#include "controller/control/delays.h"
#include "controller/reference/shape.h"

namespace hystcan::controller {

/// Throws std::invalid_argument if a parameter of the loop is out of range.
PlantInverse::Config design_plant_inverse(const LoopConfig& loop);

/// Sets plant_inverse of the axis if its `delays` request it; otherwise leaves it empty.
void plan_feed_forward(AxisConfig& axis, double rate_Hz);

// The smallest tracking error that any sequence of setpoints can have, including the position between the
// samples.
//
// A setpoint changes once in a cycle T. Between two changes the position depends only on hold, amplifier and
// mode, so even the best sequence leaves an error. For a reference of N cycles per period with the harmonics
// R_q, the setpoints u[0..N-1] have the DFT U_k, k = 0..N-1. They affect every harmonic q = k + m N, for all
// integers m:
//
//   X_q = P_q U_k,   P: response_between_samples() (a delay changes nothing)
//
// The mean square of the error, sum |R_q - P_q U_k|^2, separates into one least-squares problem per k:
//
//   floor^2 = sum_k ( sum_m |R_q|^2 - |sum_m conj(P_q) R_q|^2 / sum_m |P_q|^2 )

/// Returns the RMS of the error, um, for a reference that repeats every `cycles` cycles. R_q is computed from
/// about a hundred values per cycle of 1 ms, and at least 16. The pure delays and the sensor of `delays` are
/// ignored.
double tracking_floor_um(const Delays& delays, double cycle_s, std::size_t cycles,
                         const std::function<double(double t_s)>& reference_um);

/// Returns the smallest RMS error for a shape that repeats, without the beginning of the shape. Returns
/// `nullopt` if the shape does not repeat, or if no multiple of its period up to 100 periods is a whole
/// number of cycles.
std::optional<double> tracking_floor_um(const Delays& delays, double cycle_s, const Shape& shape);

}  // namespace hystcan::controller
