#include "identification/regression.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::identification {
namespace {

using model::Direction;

// to.H += a b' + b a'
void add_symmetric(NormalEquations& to, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  to.H.noalias() += a * b.transpose();
  to.H.noalias() += b * a.transpose();
}

// curve_row() as a matrix: it maps T_0, ..., T_n to a row of theta.
Eigen::MatrixXd curve_rows(Direction direction, Eigen::Index order) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2 * order + 1, order + 1);
  rows.topRows(order + 1).setIdentity();
  if (direction == Direction::ascending) return rows;
  rows.bottomLeftCorner(order, 1).setOnes();
  rows.bottomRightCorner(order, order) = -Eigen::MatrixXd::Identity(order, order);
  return rows;
}

}  // namespace

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  H += other.H;
  g += other.g;
  square += other.square;
  samples += other.samples;
  return *this;
}

NormalEquations& NormalEquations::operator-=(const NormalEquations& other) {
  H -= other.H;
  g -= other.g;
  square -= other.square;
  samples -= other.samples;
  return *this;
}

double NormalEquations::residual_square(const Eigen::VectorXd& theta) const {
  return std::max(0.0, theta.dot(H * theta - 2.0 * g) + square);
}

Regression::Regression(Path path, model::Interval thresholds, int order, std::span<const double> input,
                       std::span<const double> output, std::span<const int> fold, int folds)
    : path_(std::move(path)), thresholds_(thresholds), order_(order) {
  base_.assign(static_cast<std::size_t>(folds), NormalEquations(unknowns()));
  gather(input, output, fold);
  for (Sums& run : runs_) sum_up(run);
}

void Regression::gather(std::span<const double> input, std::span<const double> output,
                        std::span<const int> fold) {
  const auto counted = std::ranges::count_if(fold, [](int part) { return part != left_out; });
  basis_.resize(order_ + 1, counted);
  distance_.resize(counted);
  output_.resize(counted);
  Eigen::Index row = 0;
  for (const Run& run : path_.runs)
    for (std::size_t i = run.begin; i < run.end; ++i) {
      if (fold[i] == left_out) continue;
      if (runs_.empty() || runs_.back().branch != run.branch || runs_.back().fold != fold[i])
        runs_.push_back({run.branch, fold[i], row, 0, {}, 0.0});
      const double v = std::clamp(input[i], thresholds_.lo, thresholds_.hi);
      chebyshev_row(thresholds_, v, basis_.col(row));
      distance_[row] = std::abs(v - path_.branches[run.branch].start);
      output_[row] = output[i];
      runs_.back().count = ++row - runs_.back().begin;
    }
}

void Regression::sum_up(Sums& run) {
  const auto T = basis_.middleCols(run.begin, run.count);
  const auto y = output_.segment(run.begin, run.count);
  run.basis = T.rowwise().sum();
  run.output = y.sum();
  const Eigen::MatrixXd rows = curve_rows(path_.branches[run.branch].direction, order_);
  NormalEquations& base = base_[static_cast<std::size_t>(run.fold)];
  base.H += rows * (T * T.transpose()) * rows.transpose();
  base.g += rows * (T * y);
  base.square += y.squaredNorm();
  base.samples += static_cast<double>(run.count);
}

// row = B T + c - S phi
// H is the sum of B TT' B' (already in base_) and two updates of rank two.
void Regression::add_run(const Sums& run, const Pace& pace, const BranchRows& rows,
                         NormalEquations& to) const {
  const Direction direction = path_.branches[run.branch].direction;
  const double k = pace.k(direction);
  const auto d = distance_.segment(run.begin, run.count).array();
  const auto y = output_.segment(run.begin, run.count);
  Eigen::VectorXd phi = d;
  if (std::abs(k) * thresholds_.span() > 1e-6) phi = (1.0 - (-k * d).exp()) / k;
  const auto c = rows.offset(run.branch), S = rows.convergence(run.branch);
  const Eigen::VectorXd T_phi = basis_.middleCols(run.begin, run.count) * phi;
  const double sum_phi = phi.sum(), count = static_cast<double>(run.count);
  add_symmetric(to, c, curve_row(direction, run.basis, count) + 0.5 * count * c - sum_phi * S);
  add_symmetric(to, S, 0.5 * phi.squaredNorm() * S - curve_row(direction, T_phi, sum_phi));
  to.g += c * run.output - S * phi.dot(y);
}

void Regression::add(const Pace& pace, std::vector<NormalEquations>& folds) const {
  for (std::size_t fold = 0; fold < base_.size(); ++fold) folds[fold] += base_[fold];
  const BranchRows rows(path_, thresholds_, order_, pace);
  for (const Sums& run : runs_) add_run(run, pace, rows, folds[static_cast<std::size_t>(run.fold)]);
}

}  // namespace hystcan::identification
