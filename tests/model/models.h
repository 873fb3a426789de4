// Three fixed models and random models for the tests.
#pragma once

#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>
#include <stdexcept>
#include <vector>

#include "model/hysteresis.h"

namespace hystcan::model {

/// f_A = 0.2 v, f_D = 1.5 + 0.185 v on [0, 100]; both k the same.
inline HysteresisParameters linear_model(double k = 0.05) {
  const Interval range{0.0, 100.0};
  return {"V",
          "um",
          ReferenceCurve(Basis::power, {0.0, 0.2}, range),
          ReferenceCurve(Basis::power, {1.5, 0.185}, range),
          k,
          k,
          Symmetry::none};
}

/// A model like a piezo stage: third order on 0..100 V, 30 um, loops of 12 % of the stroke.
inline HysteresisParameters piezo_model() {
  const Interval range{0.0, 100.0};
  return {"V",
          "um",
          ReferenceCurve(Basis::power, {0.0, 0.25, 4e-4, 1e-6}, range),
          ReferenceCurve(Basis::power, {0.8, 0.372, -8e-4}, range),
          0.05,
          0.04,
          Symmetry::none};
}

/// Tenth order on 0..3 A, folded: x(v) = x(-v).
inline HysteresisParameters galfenol_model() {
  const Interval range{0.0, 3.0};
  std::vector<double> ascending{0.0, 4.0, 14.0, -6.0, 0.9, 0.01, -0.004, 0.0002, 1e-5, -2e-6, 1e-7};
  const ReferenceCurve curve(Basis::power, ascending, range);
  std::vector<double> descending = ascending;
  // + 1.2 (1 - t) (0.2 + t), t = v / 3 A
  descending[0] += 0.24;
  descending[1] += 1.2 * 0.8 / 3.0;
  descending[2] -= 1.2 / 9.0;
  return {"A", "um", curve, ReferenceCurve(Basis::power, descending, range), 1.0, 1.2, Symmetry::even};
}

/// Chebyshev coefficients of a polynomial of t = (v - lo) / span, by interpolation at Chebyshev's points.
inline std::vector<double> chebyshev_of(const std::function<long double(long double)>& f, int order) {
  const int n = order + 1;
  std::vector<double> c;
  for (int j = 0; j < n; ++j) {
    long double sum = 0;
    for (int i = 0; i < n; ++i) {
      const long double angle = std::numbers::pi_v<long double> * (i + 0.5L) / n;
      sum += f((std::cos(angle) + 1) / 2) * std::cos(j * angle);
    }
    c.push_back(static_cast<double>(sum * (j == 0 ? 1 : 2) / n));
  }
  return c;
}

inline rc::Gen<double> number(double lo, double hi) {
  return rc::gen::map(rc::gen::inRange(0, 1'000'001), [=](int i) { return lo + (hi - lo) * i / 1e6; });
}

/// Increasing curves of order 1 to 24 that meet at the top, with t = (v - lo) / span:
///
///   f_A = A sum a_i p_i(t),     p_i = t^i or 1 - (1 - t)^i
///   f_D = f_A + gap(t)
///
/// The gap is small enough that f_D increases, too; its width parameter is at most 0.25.
struct RandomModel {
  /// Every third model has splines.
  static HysteresisParameters draw() {
    const HysteresisParameters drawn = draw_unchecked();
    return within_validity(*rc::gen::inRange(0, 3) == 0 ? with_splines(drawn) : drawn);
  }

  /// The curves as splines of 1 to 12 pieces. Coefficients that are values of an increasing function make an
  /// increasing spline.
  static HysteresisParameters with_splines(HysteresisParameters p) {
    const Interval& range = p.input_range();
    std::vector<double> knots{range.lo};
    const auto widths = *rc::gen::container<std::vector<double>>(
        static_cast<std::size_t>(*rc::gen::inRange(1, 13)), number(0.02, 1.0));
    const double sum = std::accumulate(widths.begin(), widths.end(), 0.0);
    for (const double width : widths) knots.push_back(knots.back() + width / sum * range.span());
    knots.back() = range.hi;
    const auto spline = [&](const ReferenceCurve& curve) {
      std::vector<double> coefficients;
      for (const double v : greville_points(knots)) coefficients.push_back(curve.value(v));
      coefficients.back() = p.upper_point().level;
      return ReferenceCurve(CubicSpline(knots, coefficients), range);
    };
    const ReferenceCurve ascending = spline(p.ascending);
    p.descending = spline(p.descending);
    p.ascending = ascending;
    return p;
  }

  /// k of either sign, from zero to far beyond the limit.
  static HysteresisParameters draw_beyond_limit() {
    HysteresisParameters p = draw_unchecked();
    const auto any_k = [&] {
      const double k =
          *rc::gen::element(0.0, 1e-300, 1e-17, 1e-12, 1e-6, 0.01, 1.0, 7.0, 60.0, 900.0, 1e4, 1e5);
      const bool negative = *rc::gen::arbitrary<bool>();
      return (negative ? -std::min(k, 300.0) : k) / p.ascending.domain().span();
    };
    p.k_ascending = any_k();
    p.k_descending = any_k();
    return p;
  }

  static HysteresisParameters draw_unchecked() {
    const int order = *rc::gen::inRange(1, 25);
    const auto weights =
        *rc::gen::container<std::vector<double>>(static_cast<std::size_t>(order), number(0.0, 1.0));
    const auto bent_down =
        *rc::gen::container<std::vector<bool>>(static_cast<std::size_t>(order), rc::gen::arbitrary<bool>());
    const double lo = *rc::gen::element(0.0, -1.0, 2.5, -50.0);
    const double span = *rc::gen::element(1.0, 3.0, 100.0, 1500.0);
    const double size = *rc::gen::element(1.0, 30.0, 1e-3);
    const double width = *rc::gen::element(0.0, 0.02, 0.12, 0.25);
    const double foot = *number(0.0, 0.5);
    const auto rising = [=](long double t) {
      long double sum = t, norm = 1;
      for (int i = 1; i <= order; ++i) {
        const auto w = static_cast<long double>(weights[static_cast<std::size_t>(i - 1)]);
        sum += w * (bent_down[static_cast<std::size_t>(i - 1)] ? 1 - std::pow(1 - t, i) : std::pow(t, i));
        norm += w;
      }
      return size * sum / norm;
    };
    const double share = 1.0 / (order + 1.0);  // rising' >= size * share everywhere
    const auto falling = [=](long double t) {
      return rising(t) + size * share * width * 2 * (1 - t) * (order == 1 ? 0.5L : foot + t);
    };
    const Interval range{lo, lo + span};
    return {"V",
            "um",
            ReferenceCurve(Basis::chebyshev, chebyshev_of(rising, order), range),
            ReferenceCurve(Basis::chebyshev, chebyshev_of(falling, std::max(order, 2)), range),
            *rc::gen::element(0.0, 1e-12, -1e-9, 0.3, -0.5, 2.0, -3.0, 8.0, 30.0) / span,
            *rc::gen::element(0.0, -1e-12, 1e-9, 0.2, -0.4, 3.0, -2.0, 5.0, 50.0) / span,
            Symmetry::none};
  }

  static HysteresisParameters within_validity(HysteresisParameters p) {
    for (int i = 0; i < 20; ++i) {
      try {
        return Hysteresis(p).parameters();
      } catch (const std::invalid_argument&) {
        p.k_ascending *= 0.3;
        p.k_descending *= 0.3;
      }
    }
    throw std::logic_error("no valid k for a random model");
  }
};

/// A random walk of inputs: small steps, big jumps, repetitions, and exact returns to earlier inputs.
inline std::vector<double> random_walk(const Interval& range, int length) {
  std::vector<double> walk{range.lo + range.span() * *number(0.01, 0.99)};
  for (int i = 1; i < length; ++i) {
    const int kind = *rc::gen::inRange(0, 10);
    double next = range.lo + range.span() * *number(0.0005, 0.9995);
    if (kind < 5) next = walk.back() + 0.1 * (next - walk.back());
    if (kind == 5) next = walk[static_cast<std::size_t>(*rc::gen::inRange(0, i))];
    if (kind == 6) next = walk.back();
    if (kind == 7 && *rc::gen::inRange(0, 6) == 0) next = *rc::gen::element(range.lo, range.hi);
    walk.push_back(std::clamp(next, range.lo, range.hi));
  }
  return walk;
}

/// The same for a hundred thousand steps, with a separate generator, because rapidcheck stores every drawn
/// number. Half of the steps move back into the open loop, so that loops are nested.
inline std::vector<double> long_walk(const Interval& range, int length, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::vector<double> walk{range.lo + range.span() * share(random)};
  for (int i = 1; i < length; ++i) {
    const double kind = share(random), there = range.lo + range.span() * share(random);
    const double now = walk.back(), before = walk[static_cast<std::size_t>(std::max(0, i - 2))];
    double next = now + 0.9 * share(random) * (before - now);
    if (kind < 0.40) next = now + 0.02 * (there - now);
    if (kind < 0.06) next = walk[random() % walk.size()];
    if (kind < 0.04) next = now;
    if (kind < 0.02) next = there;
    if (kind < 0.0005) next = kind < 0.00025 ? range.lo : range.hi;
    walk.push_back(std::clamp(next, range.lo, range.hi));
  }
  return walk;
}

/// Shrinking swings around the middle of the range: `turns` nested turning points.
inline std::vector<double> nested_swings(const Interval& range, int turns) {
  std::vector<double> walk;
  for (int i = 0; i < turns; ++i) {
    const double half = 0.49 * (1.0 - static_cast<double>(i) / turns);
    walk.push_back(range.lo + range.span() * (0.5 + (i % 2 == 0 ? half : -half)));
  }
  return walk;
}

}  // namespace hystcan::model
