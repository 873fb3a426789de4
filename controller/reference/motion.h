// The motions that a reference consists of: the smooth step, the turnaround at a corner, the sawtooth, and
// the curve through points.
#pragma once

#include <vector>

namespace hystcan::controller {

/// Position, velocity and acceleration at one moment.

struct Motion {
  double value_um = 0.0;
  double velocity_um_per_s = 0.0;
  double acceleration_um_per_s2 = 0.0;
};

/// Returns the smooth step, a rise from 0 to 1 with minimum jerk: 0 for s <= 0, 1 for s >= 1, and in between
///
///   10 s^3 - 15 s^4 + 6 s^5
///
/// Its maximum slope is 15/8. The maximum of its second derivative (curvature) is 10/sqrt(3).
double smooth_step(double s);
inline constexpr double smooth_step_peak_slope = 1.875;
inline constexpr double smooth_step_peak_curvature = 5.773502691896258;

/// Returns the motion at the time `t_s` of a smooth step from `from_um` to `to_um`. The step begins at the
/// time 0 and lasts `rise_s`.
Motion smooth_rise(double from_um, double to_um, double t_s, double rise_s);

/// The range, the maximum velocity and the maximum acceleration of a motion. The program checks every
/// configured reference with these bounds before anything moves.
struct MotionBounds {
  double lowest_um = 0.0;
  double highest_um = 0.0;
  double peak_slew_um_per_s = 0.0;
  double peak_acceleration_um_per_s2 = 0.0;
};

// The turnaround is a smooth curve that replaces a corner of the reference. It excites a lightly damped
// vibration mode of the stage as little as possible.
//
//   t      time since the corner; the sharp corner is |t|
//   D      duration of the turnaround
//   T_m    period of the mode
//   p      weight of an average: p >= 0, even, with the integral 1, and 0 beyond |tau| = D / 2
//   w      the turnaround: the corner |t|, averaged with p
//
//   w(t) = integral p(tau) |t - tau| dtau,      w'' = 2 p,      w(t) = |t|  for |t| >= D / 2
//
// The straight parts of the reference do not change, and the acceleration of the turnaround is proportional
// to p. After the turnaround, a mode without damping rings with an amplitude proportional to |P(2 pi / T_m)|.
// P is the Fourier transform of p; after a sharp corner, P is 1. Therefore p is a combination whose P is
// small. It consists of boxes B_L (rectangular pulses of the length L) and of a pair of impulses I_h at
// -h / 2 and h / 2. The operator * is the convolution:
//
//   D >= T_m   p = B_{T_m} * B_{D - T_m}       a trapezoid (a box if D = T_m); the box B_{T_m} makes P = 0
//   D <  T_m   p = I_{D - L} * B_L,            two equal pulses. If their distance D - L is T_m / 2, the
//                L = max(D - T_m / 2, D / 8)     second pulse cancels what the first one excites: P = 0
//
// P(2 pi / T_m) is 0 for every D >= 4/7 T_m, so the duration need not be a whole number of periods. For
// D = T_m / 2, P(2 pi / T_m) is cos(7/16 pi) = 0.195. Between the two pulses, the reference is at rest. At
// D = T_m both forms are equal. Without a mode (T_m = 0), p is one box.
//
// The pair of pulses is the ZV input shaper of N. C. Singer, W. P. Seering, "Preshaping command inputs to
// reduce system vibration", J. Dyn. Sys. Meas. Control 112, 1990, with pulses of a finite length.

class Turnaround {
 public:
  /// Constructs a turnaround without duration: the corner stays sharp.
  Turnaround() = default;
  Turnaround(double length_s, double mode_period_s);

  double length_s() const { return 2.0 * (wide_s_ + narrow_s_ + apart_s_); }
  /// Return the turnaround w(t), which replaces the corner |t|, its slope w'(t) within -1..1, and its second
  /// derivative w''(t). `t_s`: time since the corner.
  double way_s(double t_s) const;
  double slope(double t_s) const;
  double curvature_per_s(double t_s) const;
  /// Returns the maximum of the second derivative. Returns 0 for a sharp corner: its infinite acceleration
  /// does not count.
  double peak_curvature_per_s() const;

 private:
  template <class One>
  double both(double t_s, const One& one) const;

  /// Half the length of a rectangular pulse in the acceleration of the turnaround.
  double wide_s_ = 0.0;
  /// Half the length of a second rectangle. Its convolution with the pulse of acceleration gives a trapezoid.
  /// 0: the pulse stays a rectangle.
  double narrow_s_ = 0.0;
  /// Half the distance between the two pulses of acceleration of the turnaround. 0: it has only one pulse.
  double apart_s_ = 0.0;
};

// The sawtooth is a periodic line with straight rises and falls. A turnaround (class Turnaround) rounds each
// of its corners.
//
//   y             position of the sawtooth; its lowest and highest points are at low_um and high_um
//   ideal line    the sawtooth with sharp corners. It rises by S within T_1 and falls by S within T_2
//   v_1, v_2      its speeds, v_1 = S / T_1 and v_2 = S / T_2
//   top, bottom   position of its upper and of its lower corners
//   tau           time since the nearest corner; negative before the corner
//   w(tau)        the turnaround: the function |tau| with a rounded corner at tau = 0
//
//   near an upper corner   y = top + (v_1 - v_2) tau / 2 - (v_1 + v_2) w(tau) / 2
//   near a lower corner    y = bottom + (v_1 - v_2) tau / 2 + (v_1 + v_2) w(tau) / 2
//
// With |tau| in place of w(tau), these equations give the ideal line.
//
// The lowest point of y is at the time tau_0 after the lower corner, with
// w'(tau_0) = (v_2 - v_1) / (v_1 + v_2). A turnaround does not reach the corner that it replaces. Therefore S
// is larger than high_um - low_um, and the corners of the ideal line are beyond low_um and high_um. The
// straight parts of y are on the ideal line.
//
// The time 0 is at a lowest point of y.

class Sawtooth {
 public:
  Sawtooth() = default;
  /// `rise_share`: duration of the rise as a share of the period, between 0 and 1. The turnaround must not be
  /// longer than the rise or the fall.
  Sawtooth(double low_um, double high_um, double period_s, double rise_share, const Turnaround& turnaround);

  Motion at(double t_s) const;
  /// Returns the position of the line with sharp corners instead of rounded ones (turnarounds).
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
  double lowest_s_ = 0.0;  ///< time from the sharp lower corner to the lowest point of the turnaround
  double bottom_um_ = 0.0;
  double height_um_ = 1.0;  ///< height of the sawtooth with sharp corners
};

// A position over time through given points. The pieces between the points are cubic Hermite polynomials, and
// the velocity is continuous. If the points rise or fall monotonically, the curve does so too, so that it
// never exceeds the points. It begins and ends at rest.
//
//   x_i, y_i   time in s and position in um of point i
//   h_i, d_i   duration and mean slope of piece i:  h_i = x_{i+1} - x_i,   d_i = (y_{i+1} - y_i) / h_i
//   m_i        slope of the curve at point i
//
//   m_i = 0     at both ends, and if d_{i-1} and d_i differ in sign or one of them is 0
//   m_i = 3 (h_{i-1} + h_i) / ((2 h_i + h_{i-1}) / d_{i-1} + (h_i + 2 h_{i-1}) / d_i)
//               otherwise: a weighted harmonic mean of d_{i-1} and d_i
//
// F. N. Fritsch, J. Butland, "A method for constructing local monotone piecewise cubic interpolants", SIAM J.
// Sci. Stat. Comput. 5, 1984. To evaluate the curve at one time costs O(log n) for n points.

class MonotoneCubic {
 public:
  /// Constructs a curve without points: its value is 0 at all times, and its length is 0.
  MonotoneCubic() = default;
  /// Constructs the curve through the points (x_i, y_i). The first x is subtracted from all x, so the curve
  /// begins at x = 0. Throws std::invalid_argument if there are fewer than two points, if the numbers of x
  /// and y differ, if a value is not finite, or if x does not increase.
  MonotoneCubic(std::vector<double> x, std::vector<double> y);

  /// Returns the motion at the time `x`. Before the first point, the position is the first y; after the last
  /// point, it is the last y.
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
