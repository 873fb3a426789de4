// Natural frequency, damping and delay of an actuator, from a small step or chirp around a working point.
//
//   y[n] = offset + drift n T + gain x[n] + e[n]
//   x'' + 2 zeta omega x' + omega^2 x = omega^2 u(t - d),    omega = 2 pi f
//
// The drive u[n] of a row is in effect from the time of that row until the next row (held). Before the first
// row the drive of the first row was in effect for at least d.  Cycles may have no row
// (identification/dynamics/sampled_dataset.h).  The discretisation is exact, also for fractional delays
// (model/dynamics.h), so that f may be near or above half the sampling rate. The gain is the gain of a minor
// loop from end to end; in general it differs from the slope of the major loop. The width of the loop appears
// as further inputs of the same mode (identification/dynamics/sampled_dataset.h), linear like the gain.  The
// fit cannot distinguish a first-order lag of the amplifier from delay: the lag adds 1 / (2 pi bandwidth) to
// the delay.
//
// Method.  For given (f, zeta, d) the output is linear in offset, drift, gain, loop and the state at the
// first row. (Two free decays represent this state, so that the dataset does not have to begin at rest:
// identification/dynamics/mode_response.h.) These amplitudes are solved for directly (variable projection:
// Golub and Pereyra 1973).  Levenberg-Marquardt finds (log f, log zeta, d / T), starting from the best points
// of a grid and from the mirror image 1/T - f; in the samples, this image differs from f only by the delay.
//
// Confidence: identification/numerics/nonlinear_fit.h. Intervals are +-1.96 standard errors (for f and zeta,
// of their logarithms).  Near half the sampling rate J is singular: an interval of more than +-1 % is then
// limited to values with which the fitted response differs by at most 3.84 s^2 from the best one (profile).
// Intervals include any other minimum whose sum of squares is not significantly larger (3.84 s^2).
#pragma once

#include <cstddef>
#include <stdexcept>

#include "identification/dataset.h"

namespace hystcan::identification {

struct Estimate {
  double value = 0.0;
  double standard_error = 0.0;
  double lo = 0.0;  ///< `lo` and `hi`: ends of the 95 % confidence interval
  double hi = 0.0;
};

struct SecondOrderFit {
  Estimate natural_frequency_Hz;
  Estimate damping_ratio;
  Estimate delay_s;           ///< without the hold; negative if the drive column is late
  Estimate gain;              ///< output unit per input unit
  double drift_per_s = 0.0;   ///< output units per second
  double residual_rms = 0.0;  ///< output units
  double explained = 0.0;     ///< share of the output's variance around a straight line, 0 to 1
  double cycle_s = 0.0;       ///< T
  std::size_t rows = 0;       ///< rows of the dataset
  std::size_t left_out = 0;   ///< cycles without a row between them
};

/// The search covers delays from -1 to this number of cycles, and frequencies up to this share of the
/// sampling rate.
inline constexpr int largest_delay_cycles = 10;
inline constexpr double largest_frequency_cycles = 0.65;

/// Thrown if the output follows the drive, but the dataset does not show the mode: nothing excites the mode,
/// or its frequency is too high for the sampling.
struct ModeNotShown : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// Throws ModeNotShown. Throws std::invalid_argument with the reason if the dataset determines nothing: it is
/// too short or unevenly sampled (beyond 1 %; cycles may be missing), the drive is constant, or the output
/// has another cause.
SecondOrderFit fit_second_order(const Dataset& dataset);

}  // namespace hystcan::identification
