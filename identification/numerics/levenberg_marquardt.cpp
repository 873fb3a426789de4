#include "identification/numerics/levenberg_marquardt.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "identification/numerics/least_squares.h"

namespace hystcan::identification {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double cost_of(const NonlinearProblem& problem, const VectorXd& values) {
  return (values - problem.wanted).cwiseAbs2().dot(problem.weight);
}

NonlinearFit evaluated(const NonlinearProblem& problem, const VectorXd& x) {
  const std::optional<VectorXd> values = problem.values(x);
  return {x, values ? cost_of(problem, *values) : std::numeric_limits<double>::infinity()};
}

// The problem linearised at x, without the damping, which is different in each try.
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

}  // namespace

NonlinearFit improve(const NonlinearProblem& problem, const VectorXd& start, int steps) {
  const std::optional<VectorXd> values = problem.values(start);
  if (!values) refuse("the start is not a valid model, expected a valid one");
  NonlinearFit fit{start, cost_of(problem, *values)};
  double lambda = 1e-4;
  for (int step = 0; step < steps; ++step) {
    const Linearised here(problem, fit.x);
    const double before = fit.cost;
    while (lambda < 1e6 && fit.cost == before) {
      const NonlinearFit next = evaluated(problem, here.step(lambda));
      if (next.cost < before) fit = next;
      lambda *= next.cost < before ? 0.01 : 10.0;
    }
    if (!(before - fit.cost > 1e-6 * before)) break;
    lambda = std::max(lambda, 1e-14);
  }
  return fit;
}

}  // namespace hystcan::identification
