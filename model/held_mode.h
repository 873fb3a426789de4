// The response of a second-order mode x to a drive u that is constant during each cycle and arrives after a
// delay. The response is computed once per cycle.
//
//   x'' + 2 zeta omega x' + omega^2 x = omega^2 u(t - d),    u(t) = u_n for n T <= t < (n + 1) T
//
//   omega, zeta   natural angular frequency and damping ratio of the mode
//   T             length of a cycle
//   d             delay, d = m T + phi: m whole cycles and the rest phi, 0 <= phi < T
//
// In each cycle, the delayed drive changes once, at the time phi after the start of the cycle. One exact step
// (SecondOrder) before the change and one after it therefore make an exact cycle. With the state X = (x, x'):
//
//   X[n+1] = A X[n] + b_old u[n-m-1] + b_new u[n-m],      x[n] = x(n T)
//
// A, b_old and b_new are the results of the two steps. The transfer function from u to x is 1 at rest (z =
// 1):
//
//   G(z) = (1 0) (z I - A)^-1 (b_old z^-1 + b_new) z^-m
#pragma once

#include <Eigen/Core>
#include <complex>

#include "model/second_order.h"

namespace hystcan::model {

class HeldMode {
 public:
  /// A negative delay means that the drive acts before its cycle. Throws std::invalid_argument if a parameter
  /// is not finite or out of range, if cycle_s <= 0, or if the delay exceeds a million cycles.
  HeldMode(const SecondOrder::Config& mode, double delay_s, double cycle_s);

  int whole_cycles() const { return whole_cycles_; }  ///< number of whole cycles in the delay (m)
  /// Returns the matrix A: effect of the state on the next state (equation at the top of this file).
  const Eigen::Matrix2d& transition() const { return transition_; }
  /// Returns the vector b_old: effect of the older drive on the next state (equation at the top of this
  /// file).
  const Eigen::Vector2d& from_old() const { return from_old_; }
  /// Returns the vector b_new: effect of the newer drive on the next state (equation at the top of this
  /// file).
  const Eigen::Vector2d& from_new() const { return from_new_; }

  /// Returns the state after one cycle. During the cycle, the delayed drive changes from `old_drive` to
  /// `new_drive`.
  Eigen::Vector2d step(const Eigen::Vector2d& state, double old_drive, double new_drive) const {
    return transition_ * state + from_old_ * old_drive + from_new_ * new_drive;
  }
  /// Returns the frequency response from the drive to the position. `theta` is 2 pi times frequency times
  /// cycle length.
  std::complex<double> response(double theta) const;

 private:
  int whole_cycles_;
  Eigen::Matrix2d transition_;
  Eigen::Vector2d from_old_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d from_new_ = Eigen::Vector2d::Zero();
};

}  // namespace hystcan::model
