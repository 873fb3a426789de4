#include "identification/regression.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace hystcan::identification {

namespace {

using model::Direction;

}  // namespace

Regression::Regression(Path path, CurveBasis basis, const Dataset& samples, int folds, Nuisances nuisances)
    : path_(std::move(path)),
      basis_(std::move(basis)),
      regressors_(std::ssize(samples.regressors)),
      nuisances_(nuisances) {
  base_.assign(static_cast<std::size_t>(folds), NormalEquations(unknowns()));
  gather(samples);
  sum_up();
}

void Regression::gather(const Dataset& samples) {
  const auto counted = std::ranges::count_if(samples.fold, [](int part) { return part != left_out; });
  const Eigen::Index size = basis_.size();
  columns_.resize(size + regressors_ + nuisances_.count() + 1, counted);
  distance_.resize(counted);
  weight_.setOnes(counted);
  Eigen::Index row = 0;
  const model::Interval& thresholds = basis_.thresholds();
  for (const Run& run : path_.runs)
    for (std::size_t i = run.begin; i < run.end; ++i) {
      if (samples.fold[i] == left_out) continue;
      if (runs_.empty() || runs_.back().branch != run.branch || runs_.back().fold != samples.fold[i])
        runs_.push_back({run.branch, samples.fold[i], row, 0, {}, 0.0});
      const double v = std::clamp(samples.input[i], thresholds.lo, thresholds.hi);
      auto column = columns_.col(row);
      if (!samples.weight.empty()) weight_[row] = samples.weight[i];
      basis_.values(v, column.head(size));
      column.head(size) *= weight_[row];
      column[column.size() - 1] = weight_[row] * samples.output[i];
      for (Eigen::Index r = 0; r < regressors_; ++r)
        column[size + r] = samples.regressors[static_cast<std::size_t>(r)][i];
      if (nuisances_.offset) column[size + regressors_] = 1.0;
      if (nuisances_.drift) column[column.size() - 2] = drift_course(samples.time_s, i);
      distance_[row] = std::abs(basis_.place(v) - basis_.place(path_.branches[run.branch].start));
      runs_.back().count = ++row - runs_.back().begin;
    }
  std::ranges::stable_sort(runs_, {}, &Sums::fold);
}

// A column of columns_ contains the numbers of one sample: basis functions, regressors, offset, drift,
// output. Sums the products of these numbers over the samples of each fold and direction. Then converts the
// sums into normal equations for the unknowns (curve coefficients, regressors, offset, drift).
void Regression::sum_up() {
  const Eigen::Index size = basis_.size(), wide = columns_.rows(), count = unknowns();
  std::array<std::vector<Eigen::MatrixXd>, 2> sums;
  sums.fill({base_.size(), Eigen::MatrixXd::Zero(wide, wide)});
  const auto place = [](Direction direction) { return direction == Direction::ascending ? 0U : 1U; };
  for (Sums& run : runs_) {
    const auto columns = columns_.middleCols(run.begin, run.count);
    const auto w = weight_.segment(run.begin, run.count);
    const auto fold = static_cast<std::size_t>(run.fold);
    run.columns = columns * w;
    run.square = w.squaredNorm();
    base_[fold].samples += static_cast<double>(run.count);
    sums[place(path_.branches[run.branch].direction)][fold].selfadjointView<Eigen::Lower>().rankUpdate(
        columns);
  }
  for (const Direction direction : {Direction::ascending, Direction::descending}) {
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(count + 1, wide);
    rows.topLeftCorner(basis_.unknowns(), size) = basis_.rows(direction);
    rows.bottomRightCorner(wide - size, wide - size).setIdentity();
    for (std::size_t fold = 0; fold < base_.size(); ++fold) {
      const Eigen::MatrixXd half =
          sums[place(direction)][fold].selfadjointView<Eigen::Lower>() * rows.transpose();
      const Eigen::MatrixXd all = rows * half;
      base_[fold].H += all.topLeftCorner(count, count);
      base_[fold].g += all.col(count).head(count);
      base_[fold].square += all(count, count);
    }
  }
}

// Adds the part of the normal equations that depends on the convergence rate k, for one run of samples on a
// branch. The product of theta with the row of a sample is the output. This row is
//
//   R B + c - S phi(d)
//
//   B       basis functions at the input of the sample
//   R       matrix CurveBasis::rows() for the direction of the branch
//   c, S    rows of the branch (BranchRows)
//   d       distance from the start of the branch; phi(d) = (1 - e^{-k d}) / k
//
// The term R BB' R' of the matrix H is already in base_. For the other terms, this function writes two
// columns to `left` and two to `right`. The caller adds left right' + right left' to H.
void Regression::add_run(const Sums& run, const Pace& pace, const BranchRows& rows, NormalEquations& to,
                         Eigen::Ref<Eigen::MatrixXd> left, Eigen::Ref<Eigen::MatrixXd> right) const {
  const Direction direction = path_.branches[run.branch].direction;
  const double k = pace.k(direction);
  const auto d = distance_.segment(run.begin, run.count).array();
  const auto w = weight_.segment(run.begin, run.count);
  Eigen::VectorXd phi = d;  // the distance d; below it is replaced by phi(d) times the weight of the sample
  if (std::abs(k) * basis_.thresholds().span() > 1e-6) phi = (1.0 - (-k * d).exp()) / k;
  phi.array() *= w.array();
  const Eigen::Index n = basis_.unknowns(), size = basis_.size(), own = unknowns() - n;
  const auto c = rows.offset(run.branch), S = rows.convergence(run.branch);
  const Eigen::VectorXd with_phi = columns_.middleCols(run.begin, run.count) * phi;
  left.col(0) = c;
  left.col(1) = S;
  right.col(0) = basis_.row(direction, run.columns.head(size)) + 0.5 * run.square * c - phi.dot(w) * S;
  right.col(1) = 0.5 * phi.squaredNorm() * S - basis_.row(direction, with_phi.head(size));
  to.g.head(n) += c * run.columns[size + own] - S * with_phi[size + own];
  if (own == 0) return;
  const Eigen::MatrixXd shared =
      c * run.columns.segment(size, own).transpose() - S * with_phi.segment(size, own).transpose();
  to.H.topRightCorner(n, own) += shared;
  to.H.bottomLeftCorner(own, n) += shared.transpose();
}

void Regression::add(const Pace& pace, std::vector<NormalEquations>& folds) const {
  const BranchRows rows(path_, basis_, pace);
  const Eigen::Index n = basis_.unknowns();
  Eigen::MatrixXd left(n, 2 * std::ssize(runs_)), right(n, left.cols());
  Eigen::Index run = 0;
  for (std::size_t fold = 0; fold < base_.size(); ++fold) {
    folds[fold] += base_[fold];
    const Eigen::Index first = run;
    for (; run < std::ssize(runs_) && runs_[static_cast<std::size_t>(run)].fold == static_cast<int>(fold);
         ++run)
      add_run(runs_[static_cast<std::size_t>(run)], pace, rows, folds[fold], left.middleCols(2 * run, 2),
              right.middleCols(2 * run, 2));
    const Eigen::MatrixXd half = left.middleCols(2 * first, 2 * (run - first)) *
                                 right.middleCols(2 * first, 2 * (run - first)).transpose();
    folds[fold].H.topLeftCorner(n, n) += half + half.transpose();
  }
}

}  // namespace hystcan::identification
