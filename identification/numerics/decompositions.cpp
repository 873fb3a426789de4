#include "identification/numerics/decompositions.h"

#include <Eigen/QR>

namespace hystcan::identification {

namespace {

Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposed(const Eigen::MatrixXd& a,
                                                                   double rank_tolerance) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> made;
  made.setThreshold(rank_tolerance);
  made.compute(a);
  return made;
}

}  // namespace

Eigen::Index rank_of(const Eigen::MatrixXd& a, double rank_tolerance) {
  return decomposed(a, rank_tolerance).rank();
}

Eigen::VectorXd shortest_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double rank_tolerance) {
  return decomposed(a, rank_tolerance).solve(b);
}

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a, double rank_tolerance) {
  return decomposed(a, rank_tolerance).pseudoInverse();
}

using Eigen::Index;

OrthonormalColumns::OrthonormalColumns(Eigen::MatrixXd columns)
    : q_(std::move(columns)), r_(Eigen::MatrixXd::Zero(q_.cols(), q_.cols())) {
  constexpr double dependent_length = 1e-15;
  for (Index j = 0; j < q_.cols(); ++j) {
    const double length = q_.col(j).norm();
    for (Index i = 0; i < j; ++i) {
      r_(i, j) = q_.col(i).dot(q_.col(j));
      q_.col(j) -= r_(i, j) * q_.col(i);
    }
    const double left = q_.col(j).norm();
    if (left > dependent_length * length) {
      r_(j, j) = left;
      q_.col(j) /= left;
    } else {
      q_.col(j).setZero();
    }
  }
}

std::pair<Eigen::VectorXd, Eigen::VectorXd> OrthonormalColumns::solve(Eigen::VectorXd b) const {
  Eigen::VectorXd x(q_.cols());
  for (Index j = 0; j < q_.cols(); ++j) {
    x[j] = q_.col(j).dot(b);
    b -= x[j] * q_.col(j);
  }
  for (Index j = q_.cols() - 1; j >= 0; --j) {
    x[j] = r_(j, j) > 0.0 ? x[j] / r_(j, j) : 0.0;
    x.head(j) -= x[j] * r_.col(j).head(j);
  }
  return {std::move(x), std::move(b)};
}

void OrthonormalColumns::remove_from(Eigen::Ref<Eigen::MatrixXd> b) const {
  for (Index k = 0; k < b.cols(); ++k)
    for (Index j = 0; j < q_.cols(); ++j) b.col(k) -= q_.col(j).dot(b.col(k)) * q_.col(j);
}

}  // namespace hystcan::identification
