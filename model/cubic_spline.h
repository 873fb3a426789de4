// Cubic splines: curves of any shape, twice continuously differentiable between their knots.
//
//   f(v) = sum c_i B_i(v)
//
// B_i are the cubic B-splines of the knots t_0 < ... < t_m, with the first and the last knot repeated four
// times (de Boor, A Practical Guide to Splines, 1978). There are m + 3 of them; they are never negative and
// sum to 1. scipy writes this as BSpline([t_0]*3 + t + [t_m]*3, c, 3). Outside [t_0, t_m], f continues along
// its tangents.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hystcan::model {

/// A function at one input: its value and its first two derivatives.
struct Jet {
  double value = 0.0;
  double slope = 0.0;
  double curvature = 0.0;
};

/// The four B-splines that are not zero at one input: B_first, ..., B_{first + 3}.
struct BSplines {
  std::size_t first = 0;
  std::array<Jet, 4> at{};
};

/// Evaluates the B-splines at v. `knots`: at least two, increasing.
BSplines bsplines(std::span<const double> knots, double v);

/// Returns the coefficients of f(v) = v: the mean of the three inner knots of each B-spline.
std::vector<double> greville_points(std::span<const double> knots);

class CubicSpline {
 public:
  /// Throws std::invalid_argument if there are fewer than two knots or more than 64, if the knots do not
  /// increase, or if there are not knots.size() + 2 coefficients.
  CubicSpline(std::vector<double> knots, std::vector<double> coefficients);

  double value(double v) const {
    const Piece& p = piece(v);
    const double d = v - p.start;
    return (p.a0 + p.a1 * d) + d * d * (p.a2 + p.a3 * d);
  }
  double slope(double v) const {
    const Piece& p = piece(v);
    const double d = v - p.start;
    return p.a1 + d * (2.0 * p.a2 + 3.0 * p.a3 * d);
  }
  double curvature(double v) const {
    const Piece& p = piece(v);
    return 2.0 * p.a2 + 6.0 * p.a3 * (v - p.start);
  }
  /// Returns the largest |d3f/dv3| between the first and the last knot.
  double third_derivative_bound() const {
    double largest = 0.0;
    for (const Piece& piece : pieces_) largest = std::max(largest, 6.0 * std::abs(piece.a3));
    return largest;
  }
  /// Returns value, slope and curvature at v. At the last knot, the curvature is the limit from below;
  /// outside the knots, it is 0.
  Jet jet(double v) const {
    const Piece& p = v == knots_.back() ? pieces_[pieces_.size() - 2] : piece(v);
    const double d = v - p.start;
    return {(p.a0 + p.a1 * d) + d * d * (p.a2 + p.a3 * d), p.a1 + d * (2.0 * p.a2 + 3.0 * p.a3 * d),
            2.0 * p.a2 + 6.0 * p.a3 * d};
  }

  const std::vector<double>& knots() const { return knots_; }
  const std::vector<double>& coefficients() const { return coefficients_; }

 private:
  struct Piece {  // the polynomial a0 + a1 d + a2 d^2 + a3 d^3, d = v - start
    double start, a0, a1, a2, a3;
  };
  static constexpr std::size_t cells = 256;

  // Returns the piece that contains v. A table divides the range of the knots into equal cells and stores the
  // first piece of each cell. The code does not store the last piece that was found, because threads would
  // share this state.
  const Piece& piece(double v) const {
    if (!(v >= knots_.front())) return pieces_.front();
    const double cell = (v - knots_.front()) * cells_per_input_;
    std::size_t i =
        cell < static_cast<double>(cells) ? first_in_[static_cast<std::size_t>(cell)] : pieces_.size() - 2;
    while (i + 1 < pieces_.size() && v >= pieces_[i + 1].start) ++i;
    return pieces_[i];
  }

  std::vector<double> knots_, coefficients_;
  std::vector<Piece> pieces_;  // in this order: before the first knot, between knots, beyond the last knot
  std::array<std::uint8_t, cells> first_in_{};
  double cells_per_input_ = 0.0;
};

}  // namespace hystcan::model
