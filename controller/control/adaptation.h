// Online correction of the model: a gain and an offset of its reference curves, learnt from the PI's effort.
//
// The model's output is z. The corrected model's output is gain z + offset. For a demand x, the unchanged
// inverse receives (x - offset) / gain. The integral I compensates what is wrong with the correction.
// z_mid and z_half are the middle and half the width of the model's output range. theta_1 is the correction
// at z_mid, theta_2 is the correction at the end of the range minus theta_1, both in um. A step is a
// normalised gradient:
//
//   phi     = (1, (z - z_mid) / z_half)
//   d theta = -(dt / time_constant) phi I / (phi . phi),    I += phi . d theta
//
// The integral gives up what theta takes over, so the drive does not change. theta is projected onto
//
//   |gain - 1| <= gain_max,    |offset at z_mid| <= offset_max_um
//
// Stability: a step takes the share dt / time_constant of I away, less at a bound, and never changes its
// sign. At a fixed operating point it is thus only a leak of I. With a moving reference the loop sees a gain
// within the bounds that changes over time_constant, many times slower than the loop's own 1 / ki.
// While the correction learns, the amplitude of a periodic drive changes a little with every period. This
// leaves nested turning points, two per period; the model's memory has room for them (memory_capacity).
// The caller freezes the correction while the drive is limited, a sample is missing, or the reference is in
// transition.
#pragma once

#include <cstddef>

#include "model/hysteresis_parameters.h"

namespace hystcan::controller {

/// Correction of the model's output:  corrected = gain * modelled + offset_um.
struct ModelCorrection {
  double gain = 1.0;
  double offset_um = 0.0;

  double apply(double modelled_um) const { return gain * modelled_um + offset_um; }
  double undo(double corrected_um) const { return (corrected_um - offset_um) / gain; }
};

struct Adaptation {
  struct Config {
    double gain_max = 0.1;       ///< greatest |gain - 1|, < 1
    double offset_max_um = 1.0;  ///< greatest |offset| at the middle of the model's range
    double time_constant_s = 5.0;
  };
  static constexpr std::size_t memory_capacity = 4096;  ///< branches: 2048 periods

  /// Returns the correction after dt_s; `modelled_um` is the model's output z, `integral_um` the integral I.
  static ModelCorrection step(const Config& config, const ModelCorrection& before,
                              const model::Interval& range_um, double modelled_um, double integral_um,
                              double dt_s);
  static ModelCorrection within_bounds(const Config& config, const ModelCorrection& correction,
                                       const model::Interval& range_um);
};

}  // namespace hystcan::controller
