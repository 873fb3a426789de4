// A curve through points (x_i, y_i): cubic Hermite pieces whose slopes keep it monotone wherever the points
// are, so that it never goes beyond them; once differentiable. It begins and ends at rest.
//
//   h_i = x_{i+1} - x_i,   d_i = (y_{i+1} - y_i) / h_i
//   slope m_i = 0 at both ends and where d_{i-1}, d_i differ in sign or one is 0; else the weighted harmonic
//   mean  3 (h_{i-1} + h_i) / ((2 h_i + h_{i-1}) / d_{i-1} + (h_i + 2 h_{i-1}) / d_i)
//
// F. N. Fritsch, J. Butland, "A method for constructing local monotone piecewise cubic interpolants", SIAM J.
// Sci. Stat. Comput. 5, 1984. O(log n) for a point.
#pragma once

#include <vector>

namespace hystcan::controller {

class MonotoneCubic {
 public:
  struct Point {
    double value = 0.0;
    double slope = 0.0;
    double curvature = 0.0;
  };

  /// No points: 0 everywhere, of no length.
  MonotoneCubic() = default;
  /// Throws std::invalid_argument unless there are two points or more, as many y as x, finite, x increasing.
  /// x is counted from its first value on.
  MonotoneCubic(std::vector<double> x, std::vector<double> y);

  /// Held at both ends.
  Point at(double x) const;
  double length() const { return x_.empty() ? 0.0 : x_.back(); }

  struct Range {
    double lowest = 0.0;
    double highest = 0.0;
    double peak_slope = 0.0;
    double peak_curvature = 0.0;
  };
  Range range() const;

 private:
  Point on_piece(std::size_t i, double from_x) const;

  std::vector<double> x_;
  std::vector<double> y_;
  std::vector<double> slope_;
};

}  // namespace hystcan::controller
