// The model as printed in the paper, in long double and without optimisation.
//
// The oracle stores the whole input history. Every evaluation selects the remembered turning points
// (outermost extremes first; a later extreme wipes out an earlier one) and computes their outputs from the
// outermost inwards. It computes every curve f_{n+1} from f_n with the printed quotient (eqs. 1 to 4; the
// descending curves as mirror images).
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "model/hysteresis.h"

namespace hystcan::model {

class Oracle {
 public:
  enum class Start { virgin, lower, upper };

  Oracle(const HysteresisParameters& parameters, Start start, double input)
      : p_(parameters), start_(start), history_{input} {}

  long double advance(double input) {
    drive(input);
    return output();
  }

  /// Like advance(), without the output, whose computation uses the whole history every time.
  void drive(double input) {
    if (input != history_.back()) history_.push_back(input);
  }

  long double output() const {
    const std::vector<Point> points = remembered();
    return branch(points, points.size() - 1, history_.back());
  }

  /// The number of remembered turning points, with the start of b_0.
  std::size_t depth() const { return remembered().size(); }

 private:
  struct Point {
    long double v = 0, x = 0;
    long double distance = 0;  // x_n - f_n(v_n) for the branch that starts here
  };

  static long double series(const ReferenceCurve& curve, long double v) {
    if (curve.basis() == Basis::spline) return of_splines(curve, v);
    const long double lo = curve.domain().lo, hi = curve.domain().hi;
    const long double s = (2 * v - lo - hi) / (hi - lo);
    long double before = 1, now = s, sum = 0;
    for (const double c : curve.coefficients()) {
      sum += c * before;
      const long double next = 2 * s * now - before;
      before = now;
      now = next;
    }
    return sum;
  }

  // de Boor's recursion from its definition: a B-spline is a mean of two of the degree below.
  static long double b_spline(const std::vector<long double>& t, std::size_t i, int degree, long double v) {
    if (degree == 0) {
      const bool last = t[i] < t[i + 1] && t[i + 1] == t.back();
      return t[i] <= v && (v < t[i + 1] || (last && v == t[i + 1])) ? 1.0L : 0.0L;
    }
    const auto d = static_cast<std::size_t>(degree);
    long double sum = 0;
    if (t[i + d] > t[i]) sum += (v - t[i]) / (t[i + d] - t[i]) * b_spline(t, i, degree - 1, v);
    if (t[i + d + 1] > t[i + 1])
      sum += (t[i + d + 1] - v) / (t[i + d + 1] - t[i + 1]) * b_spline(t, i + 1, degree - 1, v);
    return sum;
  }
  // Beyond the knots, the curve follows the tangents: their slopes are those of the first and the last two
  // coefficients.
  static long double of_splines(const ReferenceCurve& curve, long double v) {
    const std::vector<double>&knots = curve.knots(), &c = curve.coefficients();
    const std::size_t n = c.size();
    if (v < knots[0]) return c[0] + (v - knots[0]) * 3 * (c[1] - c[0]) / (knots[1] - knots[0]);
    if (v > knots.back())
      return c[n - 1] +
             (v - knots.back()) * 3 * (c[n - 1] - c[n - 2]) / (knots.back() - knots[knots.size() - 2]);
    std::vector<long double> t(3, knots.front());
    t.insert(t.end(), knots.begin(), knots.end());
    t.insert(t.end(), 3, knots.back());
    long double sum = 0;
    for (std::size_t i = 0; i < n; ++i) sum += c[i] * b_spline(t, i, 3, v);
    return sum;
  }

  static long double quotient(long double s, long double whole, long double k) {
    if (k <= 0) return k == 0 ? s / whole : std::expm1(k * s) / std::expm1(k * whole);
    // Numerator and denominator are multiplied by e^{-k whole}, because the printed form overflows.
    return std::exp(k * (s - whole)) * std::expm1(-k * s) / std::expm1(-k * whole);
  }

  bool rising(std::size_t j) const { return (j % 2 == 0) == bottom_rises_; }

  // f_j, from points[j] towards points[j - 1] (or the opposite threshold).
  long double branch(const std::vector<Point>& points, std::size_t j, long double v) const {
    const Interval range = p_.ascending.domain();
    const long double target = j > 0 ? points[j - 1].v : (rising(j) ? range.hi : range.lo);
    const long double k = rising(j) ? p_.k_ascending : p_.k_descending;
    return below(points, j, v) +
           points[j].distance * quotient(std::abs(target - v), std::abs(target - points[j].v), k);
  }

  long double below(const std::vector<Point>& points, std::size_t j, long double v) const {
    return j >= 2 ? branch(points, j - 2, v) : series(rising(j) ? p_.ascending : p_.descending, v);
  }

  void remember(std::vector<Point>& points, long double v, long double x) const {
    points.push_back({v, x, x - below(points, points.size(), v)});
  }

  std::vector<Point> remembered() const {
    const Interval range = p_.ascending.domain();
    std::size_t from = 0;
    bool virgin = start_ == Start::virgin;
    bottom_rises_ = start_ != Start::upper;
    for (std::size_t i = 1; i < history_.size(); ++i) {
      if (history_[i] != range.lo && history_[i] != range.hi) continue;
      from = i;
      virgin = false;
      bottom_rises_ = history_[i] == range.lo;
    }
    std::vector<Point> points;
    if (bottom_rises_)
      remember(points, range.lo, series(virgin ? p_.ascending : p_.descending, range.lo));
    else
      remember(points, range.hi, series(p_.ascending, range.hi));

    bool largest = bottom_rises_;
    while (true) {
      std::size_t extreme = from;
      for (std::size_t i = from; i < history_.size(); ++i)
        if (largest ? history_[i] >= history_[extreme] : history_[i] <= history_[extreme]) extreme = i;
      if (extreme + 1 == history_.size()) return points;
      remember(points, history_[extreme], branch(points, points.size() - 1, history_[extreme]));
      from = extreme;
      largest = !largest;
    }
  }

  HysteresisParameters p_;
  Start start_;
  std::vector<double> history_;
  mutable bool bottom_rises_ = true;
};

}  // namespace hystcan::model
