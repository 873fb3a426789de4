#include "identification/valid_curves.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "identification/numerics/least_squares.h"

namespace hystcan::identification {
namespace {

using model::Direction;

constexpr Eigen::Index points_per_step = 8;  // the grid of curves is finer than that of branches
constexpr Eigen::Index kinds = 3;            // slope rising, slope falling, gap
constexpr double least_slope = 2e-3;         // of the mean slope: flatter curves magnify noise when inverted
constexpr double least_branch = 1e-3;        // slope of a branch, of the mean slope
constexpr std::ptrdiff_t most_cuts = 60;     // kept for the next problem
constexpr int most_rounds = 60;

// Least squares with rows theta >= bounds, from the triangle R of H = R'R:
//   R theta = R'^-1 g
class WithinRows {
 public:
  WithinRows(const NormalEquations& system, const CurveBasis& basis) : triangle_(system.g.size()) {
    const Eigen::LLT<Eigen::MatrixXd> cholesky(system.H + system.samples * basis.regularisation());
    const Eigen::MatrixXd R = cholesky.matrixU();
    const Eigen::VectorXd right = cholesky.matrixL().solve(system.g);
    for (Eigen::Index i = 0; i < R.rows(); ++i) triangle_.add(R.row(i).transpose(), right[i]);
    theta_ = cholesky.solve(system.g);
  }
  const Eigen::VectorXd& theta() const { return theta_; }
  void solve(const std::vector<Eigen::VectorXd>& rows, const std::vector<double>& bounds) {
    Eigen::MatrixXd G(static_cast<Eigen::Index>(rows.size()), theta_.size());
    for (std::size_t i = 0; i < rows.size(); ++i) G.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
    const Eigen::Map<const Eigen::VectorXd> h(bounds.data(), static_cast<Eigen::Index>(bounds.size()));
    theta_ = triangle_.solve_with_inequalities(G, h).x;
  }

 private:
  LeastSquares triangle_;
  Eigen::VectorXd theta_;
};

}  // namespace

ValidCurves::ValidCurves(CurveShape shape, std::size_t scan_steps)
    : shape_(std::move(shape)),
      basis_(shape_, {0.0, 1.0}),
      scan_steps_(scan_steps),
      points_(points_per_step * static_cast<Eigen::Index>(scan_steps) + 1),
      curves_(Eigen::MatrixXd::Zero(0, basis_.unknowns())) {}

// The rows of a polynomial are the same for all thresholds; those of a spline are not.
void ValidCurves::use(model::Interval thresholds) {
  const model::Interval& present = basis_.thresholds();
  if (curves_.rows() > 0 && present.lo == thresholds.lo && present.hi == thresholds.hi) return;
  const bool fills = curves_.rows() == 0 || shape_.is_spline();
  basis_ = CurveBasis(shape_, thresholds);
  if (!fills) return;
  curves_.resize(kinds * points_, basis_.unknowns());
  Eigen::VectorXd slopes(basis_.size());
  const std::vector<double> between =
      model::grid_of(thresholds, shape_.knots, static_cast<std::size_t>(points_ - 1));
  for (Eigen::Index j = 0; j < points_; ++j) {
    const double t = shape_.is_spline()
                         ? (between[static_cast<std::size_t>(j)] - thresholds.lo) / thresholds.span()
                         : 0.5 - 0.5 * std::cos(std::numbers::pi * static_cast<double>(j) /
                                                static_cast<double>(points_ - 1));
    const double v = thresholds.lo + t * thresholds.span();
    basis_.slopes(v, slopes);
    slopes *= thresholds.span() / basis_.stretch(v);
    curves_.row(j) = basis_.row(Direction::ascending, slopes);
    curves_.row(points_ + j) = basis_.row(Direction::descending, slopes);
    curves_.row(2 * points_ + j) = basis_.gap(t);
  }
}

// Adds the worst row of every stretch in which the rows are violated.
bool ValidCurves::add_violated_curve_rows(const Eigen::VectorXd& theta, double bound,
                                          std::vector<Eigen::VectorXd>& rows) const {
  const Eigen::VectorXd excess = (curves_ * theta).array() - bound;
  const std::size_t before = rows.size();
  for (Eigen::Index kind = 0; kind < kinds; ++kind) {
    Eigen::Index worst = -1;
    for (Eigen::Index row = kind * points_; row < (kind + 1) * points_; ++row) {
      const bool is_violated = excess[row] < -0.1 * bound;
      if (is_violated && (worst < 0 || excess[row] < excess[worst])) worst = row;
      if ((!is_violated || row + 1 == (kind + 1) * points_) && worst >= 0) {
        rows.emplace_back(curves_.row(worst).transpose());
        worst = -1;
      }
    }
  }
  return rows.size() > before;
}

void ValidCurves::add_cuts(std::vector<model::DecreasingBranch> branches) {
  const model::Interval& thresholds = basis_.thresholds();
  const auto in_spans = [&](double v) {  // exactly 0 and 1 at the thresholds
    const double t = (v - thresholds.lo) / thresholds.span();
    return t < 1e-9 ? 0.0 : t > 1.0 - 1e-9 ? 1.0 : t;
  };
  for (model::DecreasingBranch& branch : branches) {
    for (double* input : {&branch.start, &branch.target, &branch.input}) *input = in_spans(*input);
    cuts_.push_back(branch);
  }
}

// The path to the branch begins at the threshold where the scan of model/validity.h begins.
Eigen::VectorXd ValidCurves::row_of(const model::DecreasingBranch& cut, const Pace& pace) const {
  const model::Interval& thresholds = basis_.thresholds();
  const auto input = [&](double spans) {
    return spans == 1.0 ? thresholds.hi : thresholds.lo + spans * thresholds.span();
  };
  const bool up = cut.direction == Direction::ascending;
  const bool to_threshold = cut.target <= 0.0 || cut.target >= 1.0;
  const bool from_threshold = up ? cut.start <= 0.0 : cut.start >= 1.0;
  std::vector<double> inputs;
  if (!to_threshold) inputs.push_back(input(cut.target));
  if (!from_threshold) inputs.push_back(input(cut.start));
  inputs.push_back(input(0.5 * (cut.start + cut.target)));
  const bool begins_low = from_threshold ? up : to_threshold ? !up : up;
  const Path path = trace(
      thresholds, begins_low ? model::Origin::lower_threshold : model::Origin::upper_threshold, {}, inputs);
  const std::size_t last = path.runs.back().branch;
  return BranchRows(path, basis_, pace).slope(path.branches[last], last, input(cut.input));
}

// The steepest slope the wrong way of a curve or a branch, in mean slopes.
double ValidCurves::violation(const Eigen::VectorXd& theta, const Pace& pace, double mean_slope) {
  const double lowest = (curves_ * theta).minCoeff();
  if (lowest < 0.0) return -lowest / (mean_slope * basis_.thresholds().span());
  const auto decreasing = model::find_decreasing_branches(basis_.parameters(theta, pace), scan_steps_);
  add_cuts(decreasing);
  double steepest = 0.0;
  for (const auto& branch : decreasing) steepest = std::max(steepest, -branch.slope / mean_slope);
  return steepest;
}

// Separates curves that cross by a gap whose row in curves_ is 1. Mixing with a line cannot separate
// them, because a line has no gap.
void ValidCurves::separate_curves(Eigen::VectorXd& theta, double bound) const {
  const double gap = (curves_.bottomRows(points_) * theta).minCoeff();
  if (gap < 0.0) theta += (bound - gap) * basis_.open();
}

// Slopes are linear in theta, and on a straight line without a loop all slopes are those of the line. Mixing
// with a share of the line that corresponds to the violation therefore makes all slopes valid.
void ValidCurves::mix_with_line(Eigen::VectorXd& theta, double violation, const NormalEquations& system,
                                double least_rise) const {
  Eigen::MatrixXd lines(theta.size(), 2);
  lines << basis_.constant(), basis_.line();
  Eigen::Vector2d best = (lines.transpose() * system.H * lines).ldlt().solve(lines.transpose() * system.g);
  best[1] = std::max(best[1], 0.5 * least_rise);
  const Eigen::VectorXd line = lines * best;
  const double share = std::min(1.0, 1.2 * violation / (0.5 + violation) + 1e-9);
  theta += share * (line - theta);
}

ValidCurves::Solution ValidCurves::solve(const NormalEquations& system, model::Interval thresholds,
                                         const Pace& pace, double output_span, double input_span) {
  use(thresholds);
  WithinRows least_squares(system, basis_);
  const double mean_slope = output_span / input_span;
  const double bound = least_slope * mean_slope * thresholds.span();
  if (std::ssize(cuts_) > most_cuts) cuts_.erase(cuts_.begin(), cuts_.end() - most_cuts);
  std::vector<Eigen::VectorXd> curve_rows;
  std::size_t cuts_used = 0;
  Solution solution;
  for (int round = 0; round < most_rounds; ++round) {
    solution.theta = least_squares.theta();
    if (!add_violated_curve_rows(solution.theta, bound, curve_rows)) {
      solution.violation = violation(solution.theta, pace, mean_slope);
      if (solution.violation == 0.0) break;
      cuts_used = cuts_.size();
    }
    std::vector<Eigen::VectorXd> rows = curve_rows;
    std::vector<double> bounds(rows.size(), bound);
    for (std::size_t i = 0; i < cuts_used; ++i) {
      rows.push_back(row_of(cuts_[i], pace));
      bounds.push_back(least_branch * mean_slope);
    }
    try {
      least_squares.solve(rows, bounds);
    } catch (const std::invalid_argument&) {  // to rounding, no theta meets all inequalities
      break;
    }
  }
  separate_curves(solution.theta, bound);
  for (int round = 0; round < most_rounds; ++round) {
    solution.violation = violation(solution.theta, pace, mean_slope);
    solution.valid = solution.violation == 0.0;
    if (solution.valid) break;
    mix_with_line(solution.theta, solution.violation, system, mean_slope * thresholds.span());
  }
  return solution;
}

}  // namespace hystcan::identification
