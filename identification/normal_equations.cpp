#include "identification/normal_equations.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace hystcan::identification {

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  H += other.H;
  g += other.g;
  square += other.square;
  samples += other.samples;
  return *this;
}

void NormalEquations::take_away(const NormalEquations& other, double share) {
  H -= share * other.H;
  g -= share * other.g;
  square -= share * other.square;
  samples -= share * other.samples;
}

void NormalEquations::add(const NormalEquations& other, Eigen::Index shared, Eigen::Index H_eliminated) {
  const Eigen::Index rest = other.g.size() - shared;
  H.topLeftCorner(shared, shared) += other.H.topLeftCorner(shared, shared);
  H.block(0, H_eliminated, shared, rest) += other.H.topRightCorner(shared, rest);
  H.block(H_eliminated, 0, rest, shared) += other.H.bottomLeftCorner(rest, shared);
  H.block(H_eliminated, H_eliminated, rest, rest) += other.H.bottomRightCorner(rest, rest);
  g.head(shared) += other.g.head(shared);
  g.segment(H_eliminated, rest) += other.g.tail(rest);
  square += other.square;
  samples += other.samples;
}

void NormalEquations::divide_outputs(double gain) {
  g /= gain;
  square /= gain * gain;
}

double NormalEquations::residual_square(const Eigen::VectorXd& theta) const {
  return std::max(0.0, theta.dot(H * theta - 2.0 * g) + square);
}

void NormalEquations::leave_out(const Eigen::VectorXd& direction) {
  const Eigen::VectorXd Hd = H * direction;
  const double curvature = direction.dot(Hd), slope = direction.dot(g);
  if (!(curvature > 1e-9 * samples)) return;
  H.noalias() -= Hd * Hd.transpose() / curvature;
  g -= Hd * (slope / curvature);
  square -= slope * slope / curvature;
}

// Eliminates the last unknowns z from the equations
//
//   H11 theta + H12 z = g1,  H21 theta + H22 z = g2,     so that  z = H22^-1 (g2 - H21 theta)
//
// If no sample determines an unknown in z, this unknown is zero.
Eliminated::Eliminated(const NormalEquations& system, Eigen::Index remaining) : rest_(remaining) {
  const Eigen::Index eliminated = system.g.size() - remaining;
  rest_.H = system.H.topLeftCorner(remaining, remaining);
  rest_.g = system.g.head(remaining);
  rest_.square = system.square;
  rest_.samples = system.samples;
  if (eliminated == 0) return;
  constexpr double negligible = 1e-12;
  const Eigen::MatrixXd H_eliminated =
      system.H.bottomRightCorner(eliminated, eliminated) +
      negligible * std::max(1.0, system.samples) * Eigen::MatrixXd::Identity(eliminated, eliminated);
  const Eigen::LDLT<Eigen::MatrixXd> solver(H_eliminated);
  eliminated_at_zero_ = solver.solve(system.g.tail(eliminated));
  by_theta_ = solver.solve(system.H.bottomLeftCorner(eliminated, remaining));
  rest_.H.noalias() -= system.H.topRightCorner(remaining, eliminated) * by_theta_;
  rest_.g.noalias() -= system.H.topRightCorner(remaining, eliminated) * eliminated_at_zero_;
  rest_.square -= system.g.tail(eliminated).dot(eliminated_at_zero_);
}

Eigen::VectorXd Eliminated::completed(const Eigen::VectorXd& theta) const {
  Eigen::VectorXd all(theta.size() + eliminated_at_zero_.size());
  all.head(theta.size()) = theta;
  if (eliminated_at_zero_.size() > 0)
    all.tail(eliminated_at_zero_.size()) = eliminated_at_zero_ - by_theta_ * theta;
  return all;
}

}  // namespace hystcan::identification
