// The output of an amplifier whose target moves in a straight line, r = target + rate t, in closed form.
//
//   v' = omega e within  max(-slew, rho (-P - v)) <= omega e <= min(slew, rho (P - v)),   e = r - v
//   v' = the limit       elsewhere                                       rho = R / L, P = V / R (twin/amplifier.h)
//
// v passes through phases: lag, slew limit, voltage limit. In each of them v, e and the distance to every limit have
// the form
//
//   g(t) = a + b t + c e^{-kt}
//
//   lag       v = r - rate / omega - (e(0) - rate / omega) e^{-omega t}
//   slew      v = v(0) +- slew t
//   voltage   v = +-P + (v(0) -+ P) e^{-rho t}
//
// g has at most one extremum, which is known, so the end of a phase is found on a monotone piece of g, to rounding.
//
// v turns where e = 0. There e' = rate, so e keeps the sign of the rate from then on: v turns at most once.
#pragma once

#include <limits>

namespace hystcan::twin {

struct DriveLimits {
  double omega = 1.0;                                           ///< of the lag, 1/s
  double slew_per_s = 1.0;                                      ///< drive units per second
  double load_rate_per_s = 0.0;                                 ///< rho
  double load_limit = std::numeric_limits<double>::infinity();  ///< P; infinite: the voltage is not limited
};

struct MovingTarget {
  double output = 0.0;      ///< v(0)
  double target = 0.0;      ///< r(0)
  double rate_per_s = 0.0;  ///< of the target

  double output_after(const DriveLimits& limits, double time_s) const;
  /// When v turns; infinite where it does not turn within `time_s`.
  double turns_after_s(const DriveLimits& limits, double time_s) const;
};

}  // namespace hystcan::twin
