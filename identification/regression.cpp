#include "identification/regression.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace hystcan::identification {

namespace {

double phi(double k, double d) { return std::abs(k * d) > 1e-17 ? -std::expm1(-k * d) / k : d; }

using model::Direction;

}  // namespace

// Computes c and S as at a reversal (model/hysteresis.h), for each unknown.
BranchRows::BranchRows(const Path& path, const CurveBasis& basis, const Pace& pace)
    : basis_(basis), pace_(pace) {
  const auto count = static_cast<Eigen::Index>(path.branches.size());
  offset_ = convergence_ = Eigen::MatrixXd::Zero(basis.unknowns(), count);
  Eigen::VectorXd here(basis.size());
  for (Eigen::Index j = 0; j < count; ++j) {
    const PathBranch& branch = path.branches[static_cast<std::size_t>(j)];
    if (branch.virgin) continue;
    const double k = pace.k(branch.direction);
    const auto distance = [&](double from) {
      return std::abs(basis.place(branch.start) - basis.place(from));
    };
    const double length = distance(branch.target);
    basis.values(branch.start, here);
    Eigen::VectorXd start = basis.row(opposite(branch.direction), here);
    if (branch.parent != PathBranch::none) {
      const double d = distance(path.branches[branch.parent].start);
      start +=
          offset(branch.parent) - convergence(branch.parent) * phi(pace.k(opposite(branch.direction)), d);
    }
    offset_.col(j) = start - basis.row(branch.direction, here);
    Eigen::VectorXd gap = offset_.col(j);
    if (branch.below != PathBranch::none) {
      const double d = distance(path.branches[branch.below].start);
      gap -= offset(branch.below) - convergence(branch.below) * phi(k, d);
      convergence_.col(j) = convergence(branch.below) * std::exp(-k * d);
    }
    if (length > 0.0) convergence_.col(j) += gap / phi(k, length);
  }
}

Eigen::VectorXd BranchRows::slope(const PathBranch& shape, std::size_t branch, double input) const {
  Eigen::VectorXd here(basis_.size());
  basis_.slopes(input, here);
  const double d = std::abs(basis_.place(input) - basis_.place(shape.start));
  const double decay = std::exp(-pace_.k(shape.direction) * d);
  return basis_.row(shape.direction, here) / basis_.stretch(input) -
         sign(shape.direction) * decay * convergence(branch);
}

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

// H11 theta + H12 z = g1,  H21 theta + H22 z = g2:  z = H22^-1 (g2 - H21 theta).
// Where no sample determines a z, it is zero.
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

// The products of the columns of a fold in one direction are summed before they become rows of theta.
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

// row = R B + c - S phi
// H is the sum of R BB' R' (already in base_), l r' and r l' for the two columns of `left` and `right`.
void Regression::add_run(const Sums& run, const Pace& pace, const BranchRows& rows, NormalEquations& to,
                         Eigen::Ref<Eigen::MatrixXd> left, Eigen::Ref<Eigen::MatrixXd> right) const {
  const Direction direction = path_.branches[run.branch].direction;
  const double k = pace.k(direction);
  const auto d = distance_.segment(run.begin, run.count).array();
  const auto w = weight_.segment(run.begin, run.count);
  Eigen::VectorXd phi = d;  // weighted, as B and y are
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
