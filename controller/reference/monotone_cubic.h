// A curve through points (x_i, y_i): cubic Hermite pieces, once differentiable. Where the points are monotone
// the curve is monotone too, so it never goes beyond them. It begins and ends at rest.
//
//   h_i = x_{i+1} - x_i,   d_i = (y_{i+1} - y_i) / h_i
//
//   slope m_i = 0                       at both ends, and where d_{i-1}, d_i differ in sign or one is 0
//         m_i = 3 (h_{i-1} + h_i) / ((2 h_i + h_{i-1}) / d_{i-1} + (h_i + 2 h_{i-1}) / d_i)
//                                       elsewhere: the weighted harmonic mean
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

  /// A curve without points is 0 everywhere and has length 0.
  MonotoneCubic() = default;
  /// Throws std::invalid_argument unless there are two points or more, as many y as x, all finite, x
  /// increasing. The curve begins at x = 0: the first x is subtracted from all.
  MonotoneCubic(std::vector<double> x, std::vector<double> y);

  /// The curve is held before its beginning and after its end.
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
