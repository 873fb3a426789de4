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

void NormalEquations::add(const NormalEquations& other, Eigen::Index shared, Eigen::Index own) {
  const Eigen::Index rest = other.g.size() - shared;
  H.topLeftCorner(shared, shared) += other.H.topLeftCorner(shared, shared);
  H.block(0, own, shared, rest) += other.H.topRightCorner(shared, rest);
  H.block(own, 0, rest, shared) += other.H.bottomLeftCorner(rest, shared);
  H.block(own, own, rest, rest) += other.H.bottomRightCorner(rest, rest);
  g.head(shared) += other.g.head(shared);
  g.segment(own, rest) += other.g.tail(rest);
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

// H11 theta + H12 z = g1,  H21 theta + H22 z = g2:  z = H22^-1 (g2 - H21 theta). If no sample determines a z,
// it is zero.
Eliminated::Eliminated(const NormalEquations& system, Eigen::Index kept) : rest_(kept) {
  const Eigen::Index gone = system.g.size() - kept;
  rest_.H = system.H.topLeftCorner(kept, kept);
  rest_.g = system.g.head(kept);
  rest_.square = system.square;
  rest_.samples = system.samples;
  if (gone == 0) return;
  constexpr double none = 1e-12;
  const Eigen::MatrixXd own = system.H.bottomRightCorner(gone, gone) +
                              none * std::max(1.0, system.samples) * Eigen::MatrixXd::Identity(gone, gone);
  const Eigen::LDLT<Eigen::MatrixXd> solver(own);
  alone_ = solver.solve(system.g.tail(gone));
  by_theta_ = solver.solve(system.H.bottomLeftCorner(gone, kept));
  rest_.H.noalias() -= system.H.topRightCorner(kept, gone) * by_theta_;
  rest_.g.noalias() -= system.H.topRightCorner(kept, gone) * alone_;
  rest_.square -= system.g.tail(gone).dot(alone_);
}

Eigen::VectorXd Eliminated::completed(const Eigen::VectorXd& theta) const {
  Eigen::VectorXd all(theta.size() + alone_.size());
  all.head(theta.size()) = theta;
  if (alone_.size() > 0) all.tail(alone_.size()) = alone_ - by_theta_ * theta;
  return all;
}

}  // namespace hystcan::identification
