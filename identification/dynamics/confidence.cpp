#include "identification/dynamics/confidence.h"

#include <algorithm>
#include <cmath>

#include "identification/numerics/orthogonal_decomposition.h"

namespace hystcan::identification {
namespace {

/// sum_l w_l sum_n g_n g_{n+l}'.
Eigen::MatrixXd scatter(const Eigen::MatrixXd& scores) {
  const Eigen::Index rows = scores.rows();
  const auto reach = static_cast<Eigen::Index>(std::sqrt(static_cast<double>(rows)));
  Eigen::MatrixXd sum = scores.transpose() * scores;
  for (Eigen::Index lag = 1; lag <= reach; ++lag) {
    const double weight = 1.0 - static_cast<double>(lag) / static_cast<double>(reach + 1);
    const Eigen::MatrixXd lagged = scores.topRows(rows - lag).transpose() * scores.bottomRows(rows - lag);
    sum += weight * (lagged + lagged.transpose());
  }
  return sum;
}

}  // namespace

Confidence confidence_of(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual,
                         Eigen::Index unknowns) {
  constexpr double normal_tolerance = 1e-15;
  const Eigen::RowVectorXd scale = jacobian.colwise().norm().cwiseMax(1e-300);
  const Eigen::MatrixXd scaled = jacobian.array().rowwise() / scale.array();
  const Eigen::MatrixXd inverse =
      OrthogonalDecomposition(scaled.transpose() * scaled, normal_tolerance).pseudo_inverse();
  const double freedom = static_cast<double>(jacobian.rows() - jacobian.cols());
  const double variance = residual.squaredNorm() / freedom;
  const Eigen::MatrixXd scores = scaled.array().colwise() * residual.array();
  const Eigen::ArrayXd plain = variance * inverse.diagonal().array();
  const Eigen::ArrayXd correlated = (inverse * scatter(scores) * inverse).diagonal().array();
  const double widened = (correlated / plain.max(1e-300)).head(unknowns).maxCoeff();
  return {(plain.max(correlated).sqrt() / scale.transpose().array()).matrix(),
          variance * std::max(widened, 1.0)};
}

}  // namespace hystcan::identification
