#include "identification/regression.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "identification/dataset.h"

namespace hystcan::identification {
namespace {

using model::Direction;

// to += a b' + b a'
void add_symmetric(Eigen::Block<Eigen::MatrixXd>& to, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  to.noalias() += a * b.transpose();
  to.noalias() += b * a.transpose();
}

}  // namespace

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

// H11 theta + H12 z = g1,  H21 theta + H22 z = g2:  z = H22^-1 (g2 - H21 theta). Where no sample determines a z,
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

Regression::Regression(Path path, CurveBasis basis, const Samples& samples, int folds, Nuisances nuisances)
    : path_(std::move(path)),
      basis_(std::move(basis)),
      regressors_(std::ssize(samples.regressors)),
      nuisances_(nuisances) {
  base_.assign(static_cast<std::size_t>(folds), NormalEquations(unknowns()));
  gather(samples);
  for (Sums& run : runs_) sum_up(run);
}

void Regression::gather(const Samples& samples) {
  const auto counted = std::ranges::count_if(samples.fold, [](int part) { return part != left_out; });
  values_.resize(basis_.size(), counted);
  beside_.resize(regressors_ + nuisances_.count(), counted);
  distance_.resize(counted);
  weight_.setOnes(counted);
  output_.resize(counted);
  Eigen::Index row = 0;
  const model::Interval& thresholds = basis_.thresholds();
  for (const Run& run : path_.runs)
    for (std::size_t i = run.begin; i < run.end; ++i) {
      if (samples.fold[i] == left_out) continue;
      if (runs_.empty() || runs_.back().branch != run.branch || runs_.back().fold != samples.fold[i])
        runs_.push_back({run.branch, samples.fold[i], row, 0, {}, 0.0, 0.0});
      const double v = std::clamp(samples.input[i], thresholds.lo, thresholds.hi);
      basis_.values(v, values_.col(row));
      for (Eigen::Index r = 0; r < regressors_; ++r)
        beside_(r, row) = samples.regressors[static_cast<std::size_t>(r)][i];
      if (nuisances_.offset) beside_(regressors_, row) = 1.0;
      if (nuisances_.drift) beside_(beside_.rows() - 1, row) = drift_course(samples.time_s, i);
      distance_[row] = std::abs(basis_.place(v) - basis_.place(path_.branches[run.branch].start));
      if (!samples.weight.empty()) weight_[row] = samples.weight[i];
      values_.col(row) *= weight_[row];
      output_[row] = weight_[row] * samples.output[i];
      runs_.back().count = ++row - runs_.back().begin;
    }
}

void Regression::sum_up(Sums& run) {
  const auto B = values_.middleCols(run.begin, run.count);
  const auto Z = beside_.middleCols(run.begin, run.count);
  const auto y = output_.segment(run.begin, run.count);
  const auto w = weight_.segment(run.begin, run.count);
  run.basis = B * w;
  run.output = y.dot(w);
  run.square = w.squaredNorm();
  const Eigen::MatrixXd rows = basis_.rows(path_.branches[run.branch].direction);
  const Eigen::Index n = basis_.unknowns(), own = beside_.rows();
  NormalEquations& base = base_[static_cast<std::size_t>(run.fold)];
  base.H.topLeftCorner(n, n) += rows * (B * B.transpose()) * rows.transpose();
  base.g.head(n) += rows * (B * y);
  if (own > 0) {
    const Eigen::MatrixXd shared = rows * (B * Z.transpose());
    base.H.topRightCorner(n, own) += shared;
    base.H.bottomLeftCorner(own, n) += shared.transpose();
    base.H.bottomRightCorner(own, own) += Z * Z.transpose();
    base.g.tail(own) += Z * y;
  }
  base.square += y.squaredNorm();
  base.samples += static_cast<double>(run.count);
}

// row = R B + c - S phi
// H is the sum of R BB' R' (already in base_) and two updates of rank two.
void Regression::add_run(const Sums& run, const Pace& pace, const BranchRows& rows,
                         NormalEquations& to) const {
  const Direction direction = path_.branches[run.branch].direction;
  const double k = pace.k(direction);
  const auto d = distance_.segment(run.begin, run.count).array();
  const auto y = output_.segment(run.begin, run.count);
  const auto w = weight_.segment(run.begin, run.count);
  Eigen::VectorXd phi = d;  // weighted, as B and y are
  if (std::abs(k) * basis_.thresholds().span() > 1e-6) phi = (1.0 - (-k * d).exp()) / k;
  phi.array() *= w.array();
  const Eigen::Index n = basis_.unknowns(), own = beside_.rows();
  const auto c = rows.offset(run.branch), S = rows.convergence(run.branch);
  const Eigen::VectorXd B_phi = values_.middleCols(run.begin, run.count) * phi;
  const double sum_phi = phi.dot(w);
  auto H = to.H.topLeftCorner(n, n);
  add_symmetric(H, c, basis_.row(direction, run.basis) + 0.5 * run.square * c - sum_phi * S);
  add_symmetric(H, S, 0.5 * phi.squaredNorm() * S - basis_.row(direction, B_phi));
  to.g.head(n) += c * run.output - S * phi.dot(y);
  if (own == 0) return;
  const auto Z = beside_.middleCols(run.begin, run.count);
  const Eigen::MatrixXd shared = c * (Z * w).transpose() - S * (Z * phi).transpose();
  to.H.topRightCorner(n, own) += shared;
  to.H.bottomLeftCorner(own, n) += shared.transpose();
}

void Regression::add(const Pace& pace, std::vector<NormalEquations>& folds) const {
  for (std::size_t fold = 0; fold < base_.size(); ++fold) folds[fold] += base_[fold];
  const BranchRows rows(path_, basis_, pace);
  for (const Sums& run : runs_) add_run(run, pace, rows, folds[static_cast<std::size_t>(run.fold)]);
}

}  // namespace hystcan::identification
