#include "identification/numerics/nonlinear_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/text.h"
#include "identification/numerics/decompositions.h"
#include "identification/numerics/least_squares.h"

namespace hystcan::identification {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double cost_of(const NonlinearProblem& problem, const VectorXd& values) {
  return (values - problem.wanted).cwiseAbs2().dot(problem.weight);
}

Minimum evaluated(const NonlinearProblem& problem, const VectorXd& x) {
  const std::optional<VectorXd> values = problem.values(x);
  return {x, values ? cost_of(problem, *values) : std::numeric_limits<double>::infinity()};
}

// A nonlinear problem, linearised at the point x. step() adds the damping, which differs from try to try.
class Linearised {
 public:
  Linearised(const NonlinearProblem& problem, const VectorXd& x) : problem_(problem), x_(x), rows_(x.size()) {
    const VectorXd values = *problem.values(x);
    const MatrixXd jacobian = problem.jacobian(x);
    for (Index i = 0; i < values.size(); ++i)
      rows_.add(jacobian.row(i).transpose(), problem.wanted[i] - values[i], problem.weight[i]);
    lengths_ = (problem.weight.cwiseSqrt().asDiagonal() * jacobian).colwise().norm();
    lengths_ = (lengths_.array() > 0.0).select(lengths_, 1.0);
  }

  VectorXd step(double lambda) const {
    LeastSquares damped = rows_;
    for (Index j = 0; j < x_.size(); ++j) damped.add(VectorXd::Unit(x_.size(), j) * lengths_[j], 0.0, lambda);
    return x_ + damped.solve_with_inequalities(problem_.g, problem_.h - problem_.g * x_).x;
  }

 private:
  const NonlinearProblem& problem_;
  VectorXd x_;
  LeastSquares rows_;
  VectorXd lengths_;
};

// Rounds to 1e-5 of the value. Without this, rounding errors would choose the value of an unknown on which
// the function does not depend.
double rounded(double value) {
  constexpr int bits = 17;
  int exponent = 0;
  const double fraction = std::frexp(value, &exponent);
  return std::ldexp(std::round(std::ldexp(fraction, bits)), exponent - bits);
}

class Simplex {
 public:
  Simplex(const std::function<double(const Eigen::VectorXd&, double)>& function,
          const std::function<bool()>& go_on, int evaluations)
      : function_(function), go_on_(go_on), evaluations_left_(evaluations) {}

  Minimum search(const Eigen::VectorXd& start, const Eigen::VectorXd& step, double tolerance) {
    const auto n = static_cast<double>(start.size());
    expand_ = 1.0 + 2.0 / n;
    contract_ = 0.75 - 0.5 / n;
    shrink_ = n > 1.0 ? 1.0 - 1.0 / n : 0.5;
    corners_.push_back(evaluate(start));
    for (Eigen::Index i = 0; i < start.size(); ++i) {
      Eigen::VectorXd corner = start;
      corner[i] += step[i];
      corners_.push_back(evaluate(corner));
    }
    sort();
    while (evaluations_left_ > 0 && go_on_() && !has_converged(tolerance)) {
      move();
      sort();
    }
    return corners_.front();
  }

 private:
  Minimum evaluate(const Eigen::VectorXd& at, double limit = std::numeric_limits<double>::infinity()) {
    --evaluations_left_;
    const double value = function_(at, limit);
    return {at, std::isfinite(value) ? rounded(value) : std::numeric_limits<double>::infinity()};
  }
  void sort() {
    std::ranges::stable_sort(corners_, [](const Minimum& a, const Minimum& b) { return a.value < b.value; });
  }
  bool has_converged(double tolerance) const {
    return corners_.back().value - corners_.front().value <= tolerance * std::abs(corners_.front().value);
  }

  void move() {
    Minimum& worst = corners_.back();
    Eigen::VectorXd centre = Eigen::VectorXd::Zero(worst.x.size());
    for (std::size_t i = 0; i + 1 < corners_.size(); ++i) centre += corners_[i].x;
    centre /= static_cast<double>(corners_.size() - 1);
    const Eigen::VectorXd direction = centre - worst.x;
    const Minimum reflected = evaluate(centre + direction, worst.value);
    if (reflected.value < corners_.front().value) {
      const Minimum expanded = evaluate(centre + expand_ * direction, reflected.value);
      worst = expanded.value < reflected.value ? expanded : reflected;
    } else if (reflected.value < corners_[corners_.size() - 2].value) {
      worst = reflected;
    } else {
      const bool outside = reflected.value < worst.value;
      const double limit = std::min(reflected.value, worst.value);
      const Minimum contracted = evaluate(centre + (outside ? contract_ : -contract_) * direction, limit);
      if (contracted.value < limit)
        worst = contracted;
      else
        shrink();
    }
  }
  void shrink() {
    const Eigen::VectorXd best = corners_.front().x;
    for (std::size_t i = 1; i < corners_.size(); ++i)
      corners_[i] = evaluate(best + shrink_ * (corners_[i].x - best));
  }

  const std::function<double(const Eigen::VectorXd&, double)>& function_;
  const std::function<bool()>& go_on_;
  int evaluations_left_;
  double expand_ = 2.0, contract_ = 0.5, shrink_ = 0.5;
  std::vector<Minimum> corners_;
};

/// Returns the sum of the products g_n g_{n+l}' over all rows n and all lags l. g_n is row n of `scores`: the
/// derivatives of value n by the unknowns, times residual n. The weight of a product decreases with |l|.
/// confidence_of() uses this sum for correlated residuals.
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

Minimum improve(const NonlinearProblem& problem, const VectorXd& start, int steps) {
  const std::optional<VectorXd> values = problem.values(start);
  if (!values) refuse("the start values are not a valid model, expected the values of a valid model");
  Minimum fit{start, cost_of(problem, *values)};
  double lambda = 1e-4;
  for (int step = 0; step < steps; ++step) {
    const Linearised here(problem, fit.x);
    const double before = fit.value;
    while (lambda < 1e6 && fit.value == before) {
      const Minimum next = evaluated(problem, here.step(lambda));
      if (next.value < before) fit = next;
      lambda *= next.value < before ? 0.01 : 10.0;
    }
    if (!(before - fit.value > 1e-6 * before)) break;
    lambda = std::max(lambda, 1e-14);
  }
  return fit;
}

Minimum minimise(const std::function<double(const Eigen::VectorXd&, double)>& function,
                 const Eigen::VectorXd& start, const Eigen::VectorXd& step, double tolerance, int evaluations,
                 const std::function<bool()>& go_on) {
  return Simplex(function, go_on, evaluations).search(start, step, tolerance);
}

Confidence confidence_of(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residual,
                         Eigen::Index unknowns) {
  constexpr double normal_tolerance = 1e-15;
  const Eigen::RowVectorXd scale = jacobian.colwise().norm().cwiseMax(1e-300);
  const Eigen::MatrixXd scaled = jacobian.array().rowwise() / scale.array();
  const Eigen::MatrixXd inverse = pseudo_inverse(scaled.transpose() * scaled, normal_tolerance);
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
