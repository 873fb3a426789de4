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

// The curves are checked on a finer grid than the branches: at this number of points for each grid step of
// the branches (ValidCurves::scan_steps_).
constexpr Eigen::Index points_per_step = 8;
// Number of conditions at each grid point: the slope of the rising curve, the slope of the falling curve, and
// the gap between the curves must be positive.
constexpr Eigen::Index kinds = 3;
// Minimum slope of a curve, as a share of the mean slope. The inverse of a flatter curve would magnify noise.
constexpr double least_slope = 2e-3;
constexpr double least_branch = 1e-3;  // minimum slope of a branch, as a share of the mean slope
// Maximum number of decreasing branches that are kept for the next call of solve().
constexpr std::ptrdiff_t most_cuts = 60;
constexpr int most_rounds = 60;
// Maximum number of conditions on the curves that are kept for the next call of solve().
constexpr std::ptrdiff_t most_rows = 40;
// A condition row . theta >= least counts as satisfied if row . theta is above this share of `least`.
constexpr double nearly = 0.9;
// Tolerance for rounding errors: the largest allowed sum of squared errors is increased by this share of the
// sum of squared outputs.
constexpr double cancellation = 1e-12;

// Least squares for theta, the coefficients of the curves, with the inequalities row . theta >= bound.
// Without the inequalities, theta would be the solution of the normal equations H theta = g. R is the upper
// triangular matrix with H = R'R. The problem is to find the shortest vector z:
//
//   R theta = R'^-1 g + z,   |z| as short as the inequalities allow
class WithinRows {
 public:
  WithinRows(const NormalEquations& system, const CurveBasis& basis)
      : cholesky_(system.H + system.samples * basis.regularisation()),
        free_(cholesky_.matrixL().solve(system.g)),
        shortest_(system.g.size()) {}
  Eigen::VectorXd theta() const { return cholesky_.matrixU().solve(free_ + shortest_.z()); }
  /// Adds the inequality row . theta >= bound. Returns false if it contradicts the former inequalities: no
  /// theta satisfies all of them, within rounding errors.
  bool meet(const Eigen::VectorXd& row, double bound) {
    const Eigen::VectorXd g = cholesky_.matrixL().solve(row);
    return shortest_.meet(g, bound - g.dot(free_));
  }

 private:
  Eigen::LLT<Eigen::MatrixXd> cholesky_;
  Eigen::VectorXd free_;
  LeastDistance shortest_;
};

// A condition for theta, the coefficients of the curves: row . theta >= least. The product row . theta is the
// slope of a curve or a branch at one input, or the gap between the curves.
struct Bound {
  Eigen::VectorXd row;
  double least;
};

// Returns the coefficients theta of the curves with the smallest sum of squared errors that satisfy the
// inequalities `bounds`. In each round, the inequality with the smallest quotient row . theta / least becomes
// active. This increases the errors and may make other inequalities inactive. Stops when the sum of squared
// errors exceeds `largest_square`; theta then may satisfy only some of the inequalities.
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

// Updates the basis and the rows of curves_ for new thresholds. The rows of a polynomial do not depend on the
// thresholds, but the rows of a spline do.
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
  // Returns the relative input: 0 at the lower threshold and 1 at the upper one. At both thresholds, the
  // result has no rounding error.
  const auto in_spans = [&](double v) {
    const double t = (v - thresholds.lo) / thresholds.span();
    return t < 1e-9 ? 0.0 : t > 1.0 - 1e-9 ? 1.0 : t;
  };
  for (model::DecreasingBranch& branch : branches) {
    for (double* input : {&branch.start, &branch.target, &branch.input}) *input = in_spans(*input);
    cuts_.push_back(branch);
  }
}

// Returns a row vector for a decreasing branch. Its product with theta (the coefficients of the curves) is
// the slope of this branch, at the input where the slope is lowest. The slope depends on the turning points
// before the branch. They are the same as in model/validity.h, which found the branch by a scan from one of
// the two thresholds.
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

// Checks the curves with the coefficients theta. If a curve decreases or the curves cross (`lowest` is
// negative), returns the steepest decrease of the output, as a multiple of the mean slope. Otherwise checks
// all branches and adds the decreasing ones to cuts_. Returns their steepest decrease, or 0 if all branches
// increase.
double ValidCurves::violation(const Eigen::VectorXd& theta, double lowest, const Pace& pace,
                              double mean_slope) {
  if (lowest < 0.0) return -lowest / (mean_slope * basis_.thresholds().span());
  const auto decreasing = model::find_decreasing_branches(basis_.parameters(theta, pace), scan_steps_);
  add_cuts(decreasing);
  double steepest = 0.0;
  for (const auto& branch : decreasing) steepest = std::max(steepest, -branch.slope / mean_slope);
  return steepest;
}

// Separates two curves that cross. For this purpose it adds a pair of curves with a positive gap,
// CurveBasis::open(), to the curves with the coefficients theta. mix_with_line() cannot separate curves,
// because a straight line has no gap.
void ValidCurves::separate_curves(Eigen::VectorXd& theta, double bound) const {
  const double gap = (curves_.bottomRows(points_) * theta).minCoeff();
  if (gap < 0.0) theta += (bound - gap) * basis_.open();
}

// Makes decreasing curves and branches increase. For this purpose it moves theta, the coefficients of the
// curves, towards the coefficients of a model without a loop, whose two curves are the same rising straight
// line. Every slope then moves towards the slope of this line. The move is larger if `violation`, the
// steepest decrease, is larger.
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
