// Natural frequency, damping and delay of an actuator from a small step or chirp about a working point.
//
//   y[n] = offset + drift n T + gain x[n] + e[n]
//   x'' + 2 zeta omega x' + omega^2 x = omega^2 u(t - d),    omega = 2 pi f
//
// The drive u[n] of a row is the one in force from that row's time until the next row's (held); before the
// first row it had been the first row's for at least d.  The discretisation is exact, fractional delays
// included (identification/dynamics/held_mode.h), so that f may lie near or above half the sampling rate. The
// gain is that of a minor loop from end to end, in general not the slope of the big loop; the loop's width
// enters as further inputs of the same mode (identification/dynamics/sampled_dataset.h), linear as the gain.
// A first-order lag of the amplifier is not told apart and shows as delay, 1 / (2 pi bandwidth).
//
// Method.  For given (f, zeta, d) the output is linear in offset, drift, gain, loop and the state at the
// first row (two free decays: the dataset need not begin at rest), which are solved for (variable projection:
// Golub and Pereyra 1973).  (log f, log zeta, d / T) are found by Levenberg-Marquardt, from the best places
// of a grid and from the mirror image 1/T - f, which samples tell apart from f only by the delay.
//
// Confidence.  With J the derivatives of the fitted output, r the residuals and g_n = J_n r_n,
//
//   cov = s^2 (J'J)^-1        and        cov = (J'J)^-1 [sum_l w_l sum_n g_n g_{n+l}'] (J'J)^-1
//
// the second for correlated residuals (Newey and West 1987, w_l = 1 - |l| / (L + 1), L = sqrt(N)); of each
// parameter the larger standard error is taken.  Intervals are +-1.96 of it (of log f and log zeta, for
// these), and reach over any other minimum whose sum of squares is not significantly larger (3.84 s^2).
#pragma once

#include <cstddef>

#include "identification/dataset.h"
#include "model/second_order.h"

namespace hystcan::identification {

struct Estimate {
  double value = 0.0;
  double standard_error = 0.0;
  double lo = 0.0;  ///< 95 % confidence interval
  double hi = 0.0;
};

struct SecondOrderFit {
  Estimate natural_frequency_Hz;
  Estimate damping_ratio;
  Estimate delay_s;           ///< beyond the hold; negative where the drive column is late
  Estimate gain;              ///< output unit per input unit
  double drift_per_s = 0.0;   ///< output units per second
  double residual_rms = 0.0;  ///< output units
  double explained = 0.0;     ///< part of the output's variance about a straight line, 0 to 1
  double cycle_s = 0.0;       ///< T
  std::size_t rows = 0;       ///< of the dataset

  model::SecondOrder::Config mode() const { return {natural_frequency_Hz.value, damping_ratio.value}; }
};

/// Delays from -1 to this many cycles are searched, and frequencies up to this part of the sampling rate.
inline constexpr int largest_delay_cycles = 10;
inline constexpr double largest_frequency_cycles = 0.65;

/// Throws std::invalid_argument, with the reason, where the dataset does not tell: too short, sampled
/// unevenly (beyond 1 %), constant drive, another cause of the output, nothing near the resonance, a
/// frequency beyond what the sampling shows.
SecondOrderFit fit_second_order(const Dataset& dataset);

}  // namespace hystcan::identification
