// Online correction of the model: a gain and an offset of its reference curves, learnt from the PI's effort.
//
// The model says z, the stage is taken to be at gain z + offset; the inverse is asked for (x - offset) / gain
// in the place of x, and is itself untouched.  Where the correction is wrong, the integral I makes up for it.
// With  phi = (1, (z - z_mid) / z_half),  z_mid and z_half the middle and half of the model's output range,
// and theta = (correction at z_mid, correction at the range's end minus that), both in um:
//
//   d theta = -(dt / time_constant) phi I / (phi . phi),    I += phi . d theta
//
// a normalised gradient.  What theta takes over, the integral gives up, so the drive does not change.
// Bounded:  theta is projected onto |gain - 1| <= gain_max, |offset at z_mid| <= offset_max_um.
// Harmless: a step takes dt / time_constant of I away, less at a bound, and never turns its sign, so at a
// fixed point of work it is no more than a leak of I; the loop sees a moving reference multiplied by a gain
// within the bounds that changes over time_constant, many times slower than the loop's own 1 / ki. While it
// learns, a periodic drive shrinks or grows a little with every period: nested turning points, two to a
// period, which the model's memory must have room for (memory_capacity). Frozen by the caller where the drive
// is limited, a sample is missing, or the reference is in transition.
#pragma once

#include <cstddef>

#include "model/hysteresis_parameters.h"

namespace hystcan::controller {

/// Of the model's output: corrected = gain * modelled + offset_um.
struct ModelCorrection {
  double gain = 1.0;
  double offset_um = 0.0;

  double apply(double modelled_um) const { return gain * modelled_um + offset_um; }
  double undo(double corrected_um) const { return (corrected_um - offset_um) / gain; }
};

struct Adaptation {
  struct Config {
    double gain_max = 0.1;       ///< |gain - 1| at most, < 1
    double offset_max_um = 1.0;  ///< at the middle of the model's range, at most
    double time_constant_s = 5.0;
  };
  static constexpr std::size_t memory_capacity = 4096;  ///< branches: 2048 periods

  /// The correction after dt_s at which the model said `modelled_um` and the integral was `integral_um`.
  static ModelCorrection step(const Config& config, const ModelCorrection& before,
                              const model::Interval& range_um, double modelled_um, double integral_um,
                              double dt_s);
  static ModelCorrection within_bounds(const Config& config, const ModelCorrection& correction,
                                       const model::Interval& range_um);
};

}  // namespace hystcan::controller
