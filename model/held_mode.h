// A second-order mode, sampled once per cycle. Its drive is held during a cycle and arrives after a delay.
//
//   x'' + 2 zeta omega x' + omega^2 x = omega^2 u(t - d),    u(t) = u_n for n T <= t < (n + 1) T
//
// With d = m T + phi, 0 <= phi < T, the drive changes once in a cycle, phi after the start of the cycle. Two
// exact steps (SecondOrder) therefore make one exact cycle, for every phi:
//
//   X[n+1] = A X[n] + b_old u[n-m-1] + b_new u[n-m],      X = (x, x'),  x[n] = x(n T)
//   G(z)   = (1 0) (z I - A)^-1 (b_old z^-1 + b_new) z^-m                    (1 at rest, z = 1)
#pragma once

#include <Eigen/Core>
#include <complex>

#include "model/second_order.h"

namespace hystcan::model {

class HeldMode {
 public:
  /// A negative delay is an advance. Throws std::invalid_argument if a parameter is not finite or out of
  /// range, or if cycle_s <= 0.
  HeldMode(const SecondOrder::Config& mode, double delay_s, double cycle_s);

  int whole_cycles() const { return whole_cycles_; }                 ///< m: whole cycles of the delay
  const Eigen::Matrix2d& transition() const { return transition_; }  ///< A: effect of state X on the next X
  const Eigen::Vector2d& from_old() const { return from_old_; }      ///< b_old: effect of u[n-m-1] on X[n+1]
  const Eigen::Vector2d& from_new() const { return from_new_; }      ///< b_new: effect of u[n-m] on X[n+1]

  /// Returns the state after one cycle with the drives u[n-m-1] and u[n-m].
  Eigen::Vector2d step(const Eigen::Vector2d& state, double old_drive, double new_drive) const {
    return transition_ * state + from_old_ * old_drive + from_new_ * new_drive;
  }
  /// Returns the frequency response G(e^{i theta}), theta = 2 pi f T.
  std::complex<double> response(double theta) const;

 private:
  int whole_cycles_;
  Eigen::Matrix2d transition_;
  Eigen::Vector2d from_old_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d from_new_ = Eigen::Vector2d::Zero();
};

}  // namespace hystcan::model
