// The root of an increasing function whose derivatives are known.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/cubic_spline.h"

namespace hystcan::model {

/// A function near one input:
///
///   f(v) = value + slope d + curvature d^2 / 2,    d = v - at
struct Expansion {
  double at = 0.0;
  double value = 0.0;
  double slope = 0.0;
  double curvature = 0.0;

  Expansion() = default;
  Expansion(double v, const Jet& jet) : at(v), value(jet.value), slope(jet.slope), curvature(jet.curvature) {}
  double operator()(double v) const {
    const double d = v - at;
    return value + d * (slope + 0.5 * d * curvature);
  }
};

struct RootStep {
  double length = 0.0;     ///< change d of the input, positive or negative
  bool is_halley = false;  ///< true: Halley's step; false: Newton's step
};

/// Returns a step d of the input towards the root of f(v) = `value`. The step starts at the input `from.at`.
/// There, f and its derivatives f' and f'' are the value, slope and curvature of `from`:
///
///   d = -2 r f' / (2 f'^2 - r f''),  r = f - value     Halley's step; used if r f'' is small beside f'^2
///   d = -r / f'                                        Newton's step; used otherwise
inline RootStep step_to(double value, const Expansion& from) {
  const double r = from.value - value;
  const double square = from.slope * from.slope, bent = 2.0 * square - r * from.curvature;
  const bool mild = bent > square && bent < 4.0 * square;
  return {-r * (mild ? 2.0 * from.slope : 1.0) / (mild ? bent : from.slope), mild};
}

/// The two stop criteria of a search. If one of them is met, the root is exact to rounding.
struct RootTolerance {
  double value = 0.0;  ///< the search ends if f(v) differs from the wanted value by at most this
  /// Upper bound of the magnitude of the third derivative of f. From this bound, is_last() computes the
  /// largest possible error of a Halley step. The search also ends after a step with an error of at most
  /// `value`.
  double third = std::numeric_limits<double>::infinity();
};

/// Returns true if a Halley step d leaves an error within the tolerance:
///
///   |f(v + d) - value| <= |d|^3 [f''^2 / (2 f') + max |f'''| / 6]
inline bool is_last(const RootStep& step, const Expansion& from, const RootTolerance& tolerance) {
  const double cube = std::abs(step.length * step.length * step.length);
  return step.is_halley && from.slope > 0.0 &&
         cube * (0.5 * from.curvature * from.curvature + from.slope * tolerance.third / 6.0) <=
             tolerance.value * from.slope;
}

/// The interval in which a root is searched, from `begin` to `end`. The search starts at `guess` if this is
/// inside the interval, else at `begin`.
struct Bracket {
  double begin = 0.0;
  double end = 0.0;
  double guess = begin;
};

struct Root {
  double input = 0.0;
  /// Value and derivatives of the function at the last input that was evaluated.
  Expansion near{};
  /// True if f(input) equals the wanted value within the tolerance, and the expansion `near` gives f(input)
  /// within the tolerance.
  bool is_met = false;
};

/// Returns the v between `begin` and `end` with f(v) = `value`, by Halley's method inside a bracket that
/// every step narrows. Where f hardly rises or bends strongly, Newton's step or halving the bracket replaces
/// Halley's step.
///
/// `jet_at(v)` returns f, f' and f'' (Jet). f increases, and f(end) is beyond `value` as seen from f(begin).
template <class JetAt>
Root root_of_increasing(const JetAt& jet_at, const Bracket& inputs, double value,
                        const RootTolerance& tolerance) {
  double lo = std::min(inputs.begin, inputs.end), hi = std::max(inputs.begin, inputs.end);
  double v = lo < inputs.guess && inputs.guess < hi ? inputs.guess : inputs.begin;
  double previous_step = hi - lo;
  Expansion here;
  for (int i = 0; i < 100; ++i) {
    here = {v, jet_at(v)};
    const double residual = here.value - value;
    if (!(hi - lo > 0.0 && std::abs(residual) > tolerance.value))
      return {v, here, std::abs(residual) <= tolerance.value};
    (residual < 0.0 ? lo : hi) = v;
    const RootStep step = step_to(value, here);
    if (is_last(step, here, tolerance)) return {std::clamp(v + step.length, lo, hi), here, true};
    const double length = std::abs(step.length);
    double next = v + step.length;
    const bool wild = !(here.slope > 0.0) || (i > 2 && length > 0.5 * previous_step);
    if (wild || !(next > lo && next < hi)) {
      const bool try_end = !wild && i < 2;
      next = try_end ? (next <= lo ? lo : hi) : lo + (hi - lo) / 2.0;
      if (next == v) next = lo + (hi - lo) / 2.0;
      if (!try_end && (next == lo || next == hi)) break;
    }
    previous_step = std::abs(next - v);
    v = next;
  }
  return {v, here, false};
}

}  // namespace hystcan::model
