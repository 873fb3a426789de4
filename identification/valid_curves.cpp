#include "identification/valid_curves.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "identification/numerics/least_distance.h"

namespace hystcan::identification {
namespace {

using model::Direction;

constexpr Eigen::Index points_per_step = 8;  // the grid of curves is finer than the grid of branches
constexpr Eigen::Index kinds = 3;            // slope rising, slope falling, gap
// Share of the mean slope: flatter curves magnify noise when inverted.
constexpr double least_slope = 2e-3;
constexpr double least_branch = 1e-3;     // slope of a branch, as a share of the mean slope
constexpr std::ptrdiff_t most_cuts = 60;  // maximum cuts kept for the next problem
constexpr int most_rounds = 60;
constexpr std::ptrdiff_t most_rows = 40;  // maximum rows of curves kept for the next problem
constexpr double nearly = 0.9;            // a bound counts as satisfied above this share of it
// Tolerance of the largest square for cancellation, as a share of the square of the outputs.
constexpr double cancellation = 1e-12;

// Least squares with rows theta >= bounds, from the triangle R of H = R'R:
//   R theta = R'^-1 g + z,   |z| as short as the rows allow
class WithinRows {
 public:
  WithinRows(const NormalEquations& system, const CurveBasis& basis)
      : cholesky_(system.H + system.samples * basis.regularisation()),
        free_(cholesky_.matrixL().solve(system.g)),
        shortest_(system.g.size()) {}
  Eigen::VectorXd theta() const { return cholesky_.matrixU().solve(free_ + shortest_.z()); }
  /// Returns false if, to rounding, no theta satisfies this row and the rows before.
  bool meet(const Eigen::VectorXd& row, double bound) {
    const Eigen::VectorXd g = cholesky_.matrixL().solve(row);
    return shortest_.meet(g, bound - g.dot(free_));
  }

 private:
  Eigen::LLT<Eigen::MatrixXd> cholesky_;
  Eigen::VectorXd free_;
  LeastDistance shortest_;
};

// A row of curves or branches, and the smallest value that it may have.
struct Bound {
  Eigen::VectorXd row;
  double least;
};

// Returns the best theta with these rows. If its residual is above the limit, it may satisfy only some of
// them. The row that is violated most, relative to its bound, is added first. Each row raises the residual
// and may make other rows inactive.
Eigen::VectorXd best_with(const std::vector<Bound>& bounds, WithinRows& least_squares,
                          const NormalEquations& system, double largest_square) {
  for (std::size_t exchanges = 10 * (bounds.size() + 1); exchanges > 0; --exchanges) {
    Eigen::VectorXd theta = least_squares.theta();
    if (system.residual_square(theta) > largest_square) return theta;
    const Bound* worst = nullptr;
    double lowest = nearly;
    for (const Bound& bound : bounds)
      if (const double share = bound.row.dot(theta) / bound.least; share < lowest) {
        worst = &bound;
        lowest = share;
      }
    if (worst == nullptr || !least_squares.meet(worst->row, worst->least)) return theta;
  }
  return least_squares.theta();
}

}  // namespace

ValidCurves::ValidCurves(CurveShape shape, std::size_t scan_steps)
    : shape_(std::move(shape)),
      basis_(shape_, {0.0, 1.0}),
      scan_steps_(scan_steps),
      points_(points_per_step * static_cast<Eigen::Index>(scan_steps) + 1),
      curves_(Eigen::MatrixXd::Zero(0, basis_.unknowns())) {}

// Updates the rows of curves_. The rows of a polynomial are the same for all thresholds; those of a spline
// are not.
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

// Returns the steepest decrease of a curve or a branch, in mean slopes.
double ValidCurves::violation(const Eigen::VectorXd& theta, double lowest, const Pace& pace,
                              double mean_slope) {
  if (lowest < 0.0) return -lowest / (mean_slope * basis_.thresholds().span());
  const auto decreasing = model::find_decreasing_branches(basis_.parameters(theta, pace), scan_steps_);
  add_cuts(decreasing);
  double steepest = 0.0;
  for (const auto& branch : decreasing) steepest = std::max(steepest, -branch.slope / mean_slope);
  return steepest;
}

// Separates curves that cross by adding a gap whose row in curves_ is 1. Mixing with a line cannot separate
// them, because a line has no gap.
void ValidCurves::separate_curves(Eigen::VectorXd& theta, double bound) const {
  const double gap = (curves_.bottomRows(points_) * theta).minCoeff();
  if (gap < 0.0) theta += (bound - gap) * basis_.open();
}

// Slopes are linear in theta, and a straight line without a loop has the same slope everywhere. Mixing in a
// share of the line that corresponds to the violation therefore makes all slopes valid.
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
                                         const Pace& pace, double output_span, double input_span,
                                         double limit) {
  use(thresholds);
  WithinRows least_squares(system, basis_);
  const double mean_slope = output_span / input_span;
  const double bound = least_slope * mean_slope * thresholds.span();
  if (std::ssize(cuts_) > most_cuts) cuts_.erase(cuts_.begin(), cuts_.end() - most_cuts);
  if (std::ssize(rows_) > most_rows) rows_.erase(rows_.begin(), rows_.end() - most_rows);
  Solution solution;
  std::vector<Bound> bounds;
  for (const Eigen::Index row : rows_) bounds.push_back({curves_.row(row), bound});
  const double largest_square = limit * limit * system.samples + cancellation * system.square;
  std::size_t cuts_used = 0;
  for (int round = 0; round < 4 * most_rounds; ++round) {
    solution.theta = best_with(bounds, least_squares, system, largest_square);
    solution.beyond_limit = system.residual_square(solution.theta) > largest_square;
    if (solution.beyond_limit) return solution;
    Eigen::Index row = 0;
    const double lowest = (curves_ * solution.theta).minCoeff(&row);
    if (lowest < nearly * bound && std::ranges::find(rows_, row) == rows_.end()) {
      rows_.push_back(row);
      bounds.push_back({curves_.row(row), bound});
      continue;
    }
    solution.violation = violation(solution.theta, lowest, pace, mean_slope);
    solution.valid = solution.violation == 0.0;
    if (solution.valid || cuts_used == cuts_.size()) break;
    for (; cuts_used < cuts_.size(); ++cuts_used)
      bounds.push_back({row_of(cuts_[cuts_used], pace), least_branch * mean_slope});
  }
  if (solution.valid) return solution;
  separate_curves(solution.theta, bound);
  for (int round = 0; round < most_rounds; ++round) {
    const double lowest = (curves_ * solution.theta).minCoeff();
    solution.violation = violation(solution.theta, lowest, pace, mean_slope);
    solution.valid = solution.violation == 0.0;
    if (solution.valid) break;
    mix_with_line(solution.theta, solution.violation, system, mean_slope * thresholds.span());
  }
  return solution;
}

}  // namespace hystcan::identification
