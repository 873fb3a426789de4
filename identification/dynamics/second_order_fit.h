// Finds natural frequency, damping ratio and delay of an actuator from a small step or chirp around a working
// point.
//
//   y[n] = offset + drift n T + gain x[n] + e[n]
//   x'' + 2 zeta omega x' + omega^2 x = omega^2 u(t - d),    omega = 2 pi f
//
//   y[n], u[n], e[n]   measured output, drive and error of row n
//   x                  response of the mode
//   f, zeta, d         natural frequency, damping ratio, delay
//   T                  length of a cycle
//
// The drive of a row acts from the time of this row until the next row. The drive of the first row is assumed
// to have acted for at least the time d before the first row. Cycles may have no row
// (identification/dynamics/sampled_dataset.h). The discretisation is exact, also for fractional delays
// (model/dynamics.h). Therefore f may be near or above half the sampling rate. The gain is the gain of a
// minor loop from end to end; it usually differs from the slope of the major loop. The width of the loop
// appears as additional inputs of the same mode (sampled_dataset.h), which are linear like the gain. The fit
// cannot distinguish a first-order lag of the amplifier from a delay: the lag adds 1 / (2 pi bandwidth) to
// the delay.
//
// Method. For a given (f, zeta, d), the output is linear in the following amplitudes: offset, drift, gain,
// loop, and the state at the first row. (Two free decays represent this state, so that the dataset need not
// begin at rest: identification/dynamics/mode_response.h.) A linear problem gives these amplitudes directly
// (variable projection: Golub and Pereyra 1973). Levenberg-Marquardt finds (log f, log zeta, d / T). It
// starts from the best points of a grid, and from the mirror image 1/T - f: at the sampling times, a mode
// with the frequency 1/T - f differs from the mode with f only by its delay.
//
// Confidence: identification/numerics/nonlinear_fit.h. An interval is +-1.96 standard errors (for f and zeta,
// of their logarithms). Near half the sampling rate, the standard errors have no meaning. An interval of more
// than +-1 % is therefore limited to values at which the fitted response differs by at most 3.84 s^2 from the
// best one (profile; s^2: variance of the residual). An interval also includes any other minimum whose sum of
// squares is larger by at most 3.84 s^2.
#pragma once

#include <cstddef>
#include <stdexcept>

#include "identification/dataset.h"

namespace hystcan::identification {

struct Estimate {
  double value = 0.0;
  double standard_error = 0.0;
  double lo = 0.0;  ///< lower end of the 95 % confidence interval; `hi` is the upper end
  double hi = 0.0;
};

struct SecondOrderFit {
  Estimate natural_frequency_Hz;
  Estimate damping_ratio;
  /// Delay d, s. It does not include the time for which the drive of a row is held until the next row. A
  /// negative delay means that the drive column is late: the stage moves before the row that contains the
  /// drive.
  Estimate delay_s;
  Estimate gain;              ///< gain from end to end of a minor loop, output units per input unit
  double drift_per_s = 0.0;   ///< linear drift of the output, output units per second
  double residual_rms = 0.0;  ///< RMS difference of measured and fitted output, output units
  /// Share of the output's variance that the fit explains, 0 to 1; a linear drift does not count.
  double explained = 0.0;
  double cycle_s = 0.0;      ///< length of a cycle (T)
  std::size_t rows = 0;      ///< rows of the dataset
  std::size_t left_out = 0;  ///< number of cycles without a row, between the first and the last row
};

/// Limits of the search: delays from -1 cycle to this number of cycles, and frequencies up to this share of
/// the sampling rate.
inline constexpr int largest_delay_cycles = 10;
inline constexpr double largest_frequency_cycles = 0.65;

/// Thrown if the output follows the drive, but the dataset does not show the mode. Either nothing excites the
/// mode, or its frequency is too high for the sampling rate.
struct ModeNotShown : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// Fits a mode with a delay to a dataset. Throws ModeNotShown if the dataset does not show the mode. Throws
/// std::invalid_argument, with the reason, if the dataset determines nothing: it is too short, its rows are
/// not evenly spaced (within 10 %; cycles may be missing), its input is constant, or its output has another
/// cause than the input.
SecondOrderFit fit_second_order(const Dataset& dataset);

}  // namespace hystcan::identification
