// The root of an increasing function whose derivatives are known.
#pragma once

#include <algorithm>
#include <cmath>

#include "model/cubic_spline.h"

namespace hystcan::model {

/// Stop criteria: the root is exact to rounding if one of them is met.
struct RootTolerance {
  double value = 0.0;  ///< the search ends if |f(v) - value| is at most this
  /// A shorter step of Halley's method ends the search if the local slope is above `slope`.
  double step = 0.0;
  double slope = 0.0;
};

/// The interval in which a root is searched, from `begin` to `end`. The search starts at `guess` if this is
/// inside the interval, else at `begin`.
struct Bracket {
  double begin = 0.0;
  double end = 0.0;
  double guess = begin;
};

/// Returns the v between `begin` and `end` with f(v) = `value`, by Halley's method inside a bracket that
/// every step narrows. Where f hardly rises or bends strongly, Newton's step or halving the bracket replaces
/// Halley's step.
///
/// `jet_at(v)` returns f, f' and f'' (Jet). f increases, and f(end) is beyond `value` as seen from f(begin).
template <class JetAt>
double root_of_increasing(const JetAt& jet_at, const Bracket& inputs, double value,
                          const RootTolerance& tolerance) {
  double lo = std::min(inputs.begin, inputs.end), hi = std::max(inputs.begin, inputs.end);
  double v = lo < inputs.guess && inputs.guess < hi ? inputs.guess : inputs.begin;
  double previous_step = hi - lo;
  for (int i = 0; i < 100; ++i) {
    const Jet here = jet_at(v);
    const double residual = here.value - value;
    if (!(hi - lo > 0.0 && std::abs(residual) > tolerance.value)) break;
    (residual < 0.0 ? lo : hi) = v;
    // Halley's v - 2 r f' / (2 f'^2 - r f'') if the curvature is small, else Newton's v - r / f'.
    const double square = here.slope * here.slope, bent = 2.0 * square - residual * here.curvature;
    const bool mild = bent > square && bent < 4.0 * square;
    const double step = residual * (mild ? 2.0 * here.slope : 1.0) / (mild ? bent : here.slope);
    double next = v - step;
    if (std::abs(step) < tolerance.step && here.slope > tolerance.slope) return std::clamp(next, lo, hi);
    const bool wild = !(here.slope > 0.0) || (i > 2 && std::abs(step) > 0.5 * previous_step);
    if (wild || !(next > lo && next < hi)) {
      const bool try_end = !wild && i < 2;
      next = try_end ? (next <= lo ? lo : hi) : lo + (hi - lo) / 2.0;
      if (next == v) next = lo + (hi - lo) / 2.0;
      if (!try_end && (next == lo || next == hi)) break;
    }
    previous_step = std::abs(next - v);
    v = next;
  }
  return v;
}

}  // namespace hystcan::model
