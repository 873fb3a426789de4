// The turnaround that takes the place of a corner, for a stage with one lightly damped mode of period T_m.
//
// The corner |t| is averaged over a turnaround of length D with a weight p >= 0, which is even, has the integral 1 and
// is 0 beyond |tau| = D / 2:
//
//   w(t) = integral p(tau) |t - tau| dtau,      w'' = 2 p,      w(t) = |t|  for |t| >= D / 2
//
// The straight parts stay as they are, and the acceleration of the turnaround has the form of p. A mode without damping
// that follows the corner rings afterwards with an amplitude proportional to |P(2 pi / T_m)|, where P is the Fourier
// transform of p, and 1 for a sharp corner. p is made of boxes B_L of the length L and of a pair of impulses I_h at
// -h / 2 and h / 2 (* is the convolution):
//
//   D >= T_m     B_{T_m} * B_{D - T_m}             a trapezoid, a box at D = T_m.  P = 0: B over one period
//   D <  T_m     I_{D - L} * B_L,                  two equal pulses.  P = 0 while D - L = T_m / 2: the second pulse
//                L = max(D - T_m / 2, D / 8)       cancels what the first one excites
//
// P(2 pi / T_m) is 0 for every D >= 4/7 T_m, so the length need not be a whole number of periods. It is
// cos(7/16 pi) = 0.195 at D = T_m / 2. Between the two pulses the reference stands still. The two forms agree at
// D = T_m. Without a mode (T_m = 0), p is one box.
//
// The pair of pulses is the ZV input shaper of N. C. Singer, W. P. Seering, "Preshaping command inputs to reduce system
// vibration", J. Dyn. Sys. Meas. Control 112, 1990, with pulses of a finite length.
#pragma once

namespace hystcan::controller {

class Turnaround {
 public:
  /// The sharp corner.
  Turnaround() = default;
  Turnaround(double length_s, double mode_period_s);

  double length_s() const { return 2.0 * (wide_s_ + narrow_s_ + apart_s_); }
  /// w(t), w'(t) in -1..1, and w''(t).
  double way_s(double t_s) const;
  double slope(double t_s) const;
  double curvature_per_s(double t_s) const;
  /// The greatest w''; 0 of a sharp corner, whose acceleration does not count.
  double peak_curvature_per_s() const;

 private:
  template <class One>
  double both(double t_s, const One& one) const;

  double wide_s_ = 0.0;    ///< half the length of the longer box
  double narrow_s_ = 0.0;  ///< half that of the shorter one; 0: there is one box
  double apart_s_ = 0.0;   ///< half the distance of the two pulses; 0: there is one
};

}  // namespace hystcan::controller
