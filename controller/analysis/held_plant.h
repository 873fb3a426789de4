// The linear plant that the loop sees once in a cycle: from the drive's setpoint to the sample.
//
// With the inverse of the hysteresis the actuator is linear with gain 1 (docs/theory.md). What is left is a chain of
// links with gain 1 at rest: amplifier and sensor (first order), mode (second order), a pure delay d.
//
//   G(s) = e^{-ds} prod_i p_i / (p_i - s)                               p_i: the poles, apart from each other
//   s(t) = 1 + sum_i c_i e^{p_i t},   c_i = -prod_{k != i} p_k / (p_k - p_i)     its response to a step, d = 0
//
// Setpoints change once in a cycle T. Summing the steps of all cycles gives the exact response of the samples, for any
// delay. With j = ceil(d / T), tau = j T - d, w = 1 / z, E_i = e^{p_i tau} / (1 - e^{p_i T} w):
//
//   held          G(z) = w^j [1 + (1 - w) sum_i c_i E_i]
//   interpolated  G(z) = w^j [w + (1 - w)(tau - sum_i c_i / p_i) / T + (1 - w)^2 / T sum_i (c_i / p_i) E_i]
//
// Interpolated: the amplifier moves in a straight line from the last setpoint to the new one, within one cycle.
#pragma once

#include <complex>

#include "controller/control/plant_inverse.h"

namespace hystcan::controller {

class HeldPlant {
 public:
  /// `longer_s` is added to the delays. Throws std::invalid_argument where a parameter is not finite or out of range.
  HeldPlant(const Delays& delays, double cycle_s, double longer_s = 0.0);

  /// G(e^{i theta}), theta = 2 pi f T.
  std::complex<double> response(double theta) const;
  /// The same as a recursion, without a notch.
  const PlantRecursion::Config& recursion() const { return plant_; }

 private:
  /// share: c_i e^{p_i tau};  interpolated: c_i e^{p_i tau} / (p_i T). constant: (tau - sum c_i / p_i) / T
  PlantRecursion::Config plant_;
};

/// From the setpoints to the position between the samples, without pure delays and without the sensor:
///
///   P(s) = h(s) / (1 + s / w_a) * w^2 / (s^2 + 2 zeta w s + w^2),   h = (1 - e^{-sT}) / (sT) held,  h^2 interpolated
std::complex<double> response_between_samples(const Delays& delays, double cycle_s, double frequency_Hz);

}  // namespace hystcan::controller
