// Designs the weights of the feed-forward that inverts the plant (PlantInverse in
// controller/control/plant_inverse.h).
//
// The feed-forward V is a weighted sum of the reference at whole cycles around the mean delay mu of the
// plant. The design minimises the error of the position, including the position between the samples:
//
//   minimise  integral W(theta) sum_m |delta_m0 - P_m V|^2 dtheta
//   P_m = N(theta) P(i w_m) e^{-i w_m d},    w_m = w + 2 pi m / T,    W = 1 / (theta^2 + theta_0^2)^2
//
//   theta      frequency, theta = w T; w: angular frequency, T: cycle
//   P          response from the setpoints to the position (response_between_samples)
//   N, d       response of the notch, command delay
//   m          number of the alias of w, 0 for w itself; delta_m0: 1 if m = 0, else 0
//   W          weight of a frequency: the power spectrum of a triangle, nearly constant below theta_0
//
// P_m V with m != 0 is the ringing between the samples. The design therefore does not invert a mode near half
// the rate, although the samples alone would allow this. Two conditions hold exactly: the gain at rest is 1,
// and the mean delay is mu. With them, the position follows a ramp without an error.
#pragma once

#include <functional>
#include <optional>

#include "controller/analysis/linear_loop.h"
#include "controller/control/axis.h"
#include "controller/control/delays.h"
#include "controller/reference/shape.h"

namespace hystcan::controller {

/// Returns the weights of the feed-forward and the nominal plant for this loop. Throws std::invalid_argument
/// if a parameter of the loop is out of range.
PlantInverse::Config design_plant_inverse(const LoopConfig& loop);

/// Designs `axis.plant_inverse` if `axis.delays` requests it; otherwise leaves it empty.
void plan_feed_forward(AxisConfig& axis, double rate_Hz);

// The tracking floor: the smallest tracking error that any sequence of setpoints can have, including the
// position between the samples.
//
// A setpoint changes once in a cycle T. Between two changes, the position depends only on the held drive, the
// amplifier and the mode, so that even the best sequence leaves an error. The reference repeats every N
// cycles and has the harmonics R_q. The setpoints u[0 .. N-1] of a period have the discrete Fourier transform
// U_k, k = 0 .. N-1. Each U_k affects the harmonics X_q of the position with q = k + m N, for all integers m:
//
//   X_q = P_q U_k,   P_q: response_between_samples() at harmonic q (a pure delay changes nothing)
//
// The mean square of the error, sum |R_q - P_q U_k|^2, separates into one least-squares problem for each k.
// Its minimum is
//
//   floor^2 = sum_k ( sum_m |R_q|^2 - |sum_m conj(P_q) R_q|^2 / sum_m |P_q|^2 )

/// Returns the tracking floor: the RMS of the smallest error in um, for a reference that repeats every
/// `cycles` cycles. The reference is evaluated every 10 us, but at least 16 times in a cycle. The pure delays
/// and the sensor of `delays` are ignored.
double tracking_floor_um(const Delays& delays, double cycle_s, std::size_t cycles,
                         const std::function<double(double t_s)>& reference_um);

/// Returns the tracking floor (RMS in um) of a shape that repeats. The transient at the beginning of the
/// shape does not count. Returns `nullopt` if the shape does not repeat, or if no multiple of its period up
/// to 100 periods is a whole number of cycles.
std::optional<double> tracking_floor_um(const Delays& delays, double cycle_s, const Shape& shape);

}  // namespace hystcan::controller
