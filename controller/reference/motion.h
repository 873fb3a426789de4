// The motions of which a reference consists: the smooth step, the turnaround at a corner, and the sawtooth.
#pragma once

#include <vector>

namespace hystcan::controller {

/// Position, velocity and acceleration at one moment.

struct Motion {
  double value_um = 0.0;
  double velocity_um_per_s = 0.0;
  double acceleration_um_per_s2 = 0.0;
};

/// The smooth step (minimum jerk), 0 for s <= 0 and 1 for s >= 1:  10 s^3 - 15 s^4 + 6 s^5 Its maximum slope
/// is 15/8, its maximum curvature 10/sqrt(3).
double smooth_step(double s);
inline constexpr double smooth_step_peak_slope = 1.875;
inline constexpr double smooth_step_peak_curvature = 5.773502691896258;

/// Returns the motion at `t_s` on a smooth step between two values that takes `rise_s`.
Motion smooth_rise(double from_um, double to_um, double t_s, double rise_s);

/// Range, velocity and acceleration of a motion. A configuration is checked by these bounds before anything
/// moves.
struct MotionBounds {
  double lowest_um = 0.0;
  double highest_um = 0.0;
  double peak_slew_um_per_s = 0.0;
  double peak_acceleration_um_per_s2 = 0.0;
};

// The turnaround that replaces a corner, for a stage with one lightly damped mode of period T_m.
//
// The corner |t| is averaged over a turnaround of length D with a weight p >= 0, which is even, has the
// integral 1 and is 0 beyond |tau| = D / 2:
//
//   w(t) = integral p(tau) |t - tau| dtau,      w'' = 2 p,      w(t) = |t|  for |t| >= D / 2
//
// The straight parts do not change, and the acceleration of the turnaround has the form of p. A mode without
// damping that follows the corner rings afterwards with an amplitude proportional to |P(2 pi / T_m)|, where P
// is the Fourier transform of p, and 1 for a sharp corner. p consists of boxes B_L (rectangular pulses of the
// length L) and of a pair of impulses I_h at -h / 2 and h / 2 (* is the convolution):
//
//   D >= T_m     B_{T_m} * B_{D - T_m}             a trapezoid, a box at D = T_m.  P = 0: B over one period
//   D <  T_m     I_{D - L} * B_L,                  two equal pulses.  P = 0 while D - L = T_m / 2: the second
//                L = max(D - T_m / 2, D / 8)       pulse cancels what the first one excites
//
// P(2 pi / T_m) is 0 for every D >= 4/7 T_m, so the length need not be a whole number of periods. For
// D = T_m / 2, P(2 pi / T_m) is cos(7/16 pi) = 0.195. Between the two pulses the reference is at rest. The
// two forms agree at D = T_m. Without a mode (T_m = 0), p is one box.
//
// The pair of pulses is the ZV input shaper of N. C. Singer, W. P. Seering, "Preshaping command inputs to
// reduce system vibration", J. Dyn. Sys. Meas. Control 112, 1990, with pulses of a finite length.

class Turnaround {
 public:
  /// Constructs a sharp corner.
  Turnaround() = default;
  Turnaround(double length_s, double mode_period_s);

  double length_s() const { return 2.0 * (wide_s_ + narrow_s_ + apart_s_); }
  /// Return w(t), its slope w'(t), which is within -1..1, and w''(t).
  double way_s(double t_s) const;
  double slope(double t_s) const;
  double curvature_per_s(double t_s) const;
  /// Returns the maximum w''; 0 for a sharp corner, whose acceleration does not count.
  double peak_curvature_per_s() const;

 private:
  template <class One>
  double both(double t_s, const One& one) const;

  double wide_s_ = 0.0;    ///< half the length of the longer box
  double narrow_s_ = 0.0;  ///< half the length of the shorter box; 0: there is one box
  double apart_s_ = 0.0;   ///< half the distance between the two pulses; 0: there is one pulse
};

// A periodic line with straight rises and falls, and a turnaround (Turnaround) at each end.
//
// The ideal line rises by S within T_1 and falls by S within T_2, with v_1 = S / T_1 and v_2 = S / T_2.
// Around its upper corner, at tau = 0, the sawtooth is
//
//   y = top + (v_1 - v_2) / 2 tau - (v_1 + v_2) / 2 w(tau)
//
// and around the lower corner its mirror image. The lowest point is at the time tau_0 after the lower corner,
// where w'(tau_0) = (v_2 - v_1) / (v_1 + v_2). S exceeds high - low by so much that the extremes of the
// sawtooth are low and high. The straight parts are therefore on the ideal line, whose corners are beyond low
// and high.
//
// Time begins at a lowest point.

class Sawtooth {
 public:
  Sawtooth() = default;
  /// `rise_share`: share of the rise in the period, T_1 / (T_1 + T_2), between 0 and 1. The turnaround must
  /// not be longer than the rise T_1 or the fall T_2.
  Sawtooth(double low_um, double high_um, double period_s, double rise_share, const Turnaround& turnaround);

  Motion at(double t_s) const;
  /// Returns the ideal line, with sharp corners.
  double ideal_um(double t_s) const;

  double period_s() const { return rise_s_ + fall_s_; }
  /// Returns the time from the lowest to the highest point.
  double way_up_s() const { return rise_s_ - 2.0 * lowest_s_; }
  double peak_slew_um_per_s() const;
  double peak_acceleration_um_per_s2() const;

 private:
  double since_corner_s(double t_s) const;
  Motion corner(double value_um, double t_s, double sign) const;

  Turnaround turnaround_;
  double rise_s_ = 0.5;
  double fall_s_ = 0.5;
  double lowest_s_ = 0.0;  ///< time of the lowest point, relative to its corner: tau_0
  double bottom_um_ = 0.0;
  double height_um_ = 1.0;  ///< S
};

// A position over time through points (x_i, y_i), x in s and y in um: cubic Hermite pieces, once
// differentiable. Where the points are monotone, the curve is monotone too, so it never exceeds them. It
// begins and ends at rest.
//
//   h_i = x_{i+1} - x_i,   d_i = (y_{i+1} - y_i) / h_i
//
//   slope m_i = 0                       at both ends, and if d_{i-1}, d_i differ in sign or one is 0
//         m_i = 3 (h_{i-1} + h_i) / ((2 h_i + h_{i-1}) / d_{i-1} + (h_i + 2 h_{i-1}) / d_i)
//                                       otherwise: the weighted harmonic mean
//
// F. N. Fritsch, J. Butland, "A method for constructing local monotone piecewise cubic interpolants", SIAM J.
// Sci. Stat. Comput. 5, 1984. A point costs O(log n).

class MonotoneCubic {
 public:
  /// Constructs a curve without points: 0 everywhere, with length 0.
  MonotoneCubic() = default;
  /// Throws std::invalid_argument unless there are at least two points, as many y as x, all finite, x
  /// increasing. The curve begins at x = 0: the first x is subtracted from all.
  MonotoneCubic(std::vector<double> x, std::vector<double> y);

  /// Returns the motion at x. The curve is held before its beginning and after its end.
  Motion at(double x) const;
  double length() const { return x_.empty() ? 0.0 : x_.back(); }

  MotionBounds bounds() const;

 private:
  Motion on_piece(std::size_t i, double from_x) const;

  std::vector<double> x_;
  std::vector<double> y_;
  std::vector<double> slope_;
};

}  // namespace hystcan::controller
