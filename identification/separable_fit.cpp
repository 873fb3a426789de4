#include "identification/separable_fit.h"

#include <algorithm>
#include <utility>

namespace hystcan::identification {
namespace {

// A held-out record remains in the fit with this share of its weight. If it were left out completely, no
// sample would determine those parts of the curves that only this record reaches. These parts would be
// arbitrary, and their errors would count against the model.
constexpr double kept_of_a_record = 0.01;

bool same_path(const Trial& a, const Trial& b) {
  const auto same = [](const InitialMemory& x, const InitialMemory& y) {
    return x.kind == y.kind && x.bias == y.bias;
  };
  return a.below == b.below && a.above == b.above && a.delay_s == b.delay_s &&
         a.creep_per_decade == b.creep_per_decade &&
         std::equal(a.memories.begin(), a.memories.end(), b.memories.begin(), b.memories.end(), same);
}

Pace pace_of(const Trial& trial, model::Interval thresholds) {
  return {trial.k_span_ascending / thresholds.span(), trial.k_span_descending / thresholds.span()};
}

// Returns the mean gain of all datasets except `dataset`. This mean predicts the gain of `dataset` when it is
// held out, because its own gain then counts as unknown.
double mean_gain_of_others(const Trial& trial, std::size_t dataset) {
  double sum = 0.0;
  for (std::size_t i = 0; i < trial.memories.size(); ++i)
    if (i != dataset) sum += trial.gain(i);
  return sum / static_cast<double>(trial.memories.size() - 1);
}

NormalEquations sum_of(const std::vector<NormalEquations>& folds) {
  NormalEquations all = folds.front();
  for (std::size_t i = 1; i < folds.size(); ++i) all += folds[i];
  return all;
}

// Returns a result with an infinite error: for a fit above the error limit, or for a convergence rate k that
// is so negative that the fit contains infinite numbers.
Fitted not_fitted() {
  Fitted fitted;
  fitted.rms = std::numeric_limits<double>::infinity();
  return fitted;
}

}  // namespace

std::optional<model::OutputCreep::Config> creep_of(double per_decade) {
  if (per_decade == 0.0) return std::nullopt;
  return model::OutputCreep::Config{.per_decade = per_decade};
}

model::Interval Problem::thresholds(const Trial& trial) const {
  const double span = observed.span();
  return {observed.lo - trial.below * span, observed.hi + trial.above * span};
}

SeparableFit::SeparableFit(const Problem& problem, CurveShape shape, std::size_t scan_steps)
    : problem_(problem), shape_(std::move(shape)), curves_(shape_, scan_steps) {}

void SeparableFit::prepare(const Trial& trial) {
  if (prepared_ && same_path(*prepared_, trial)) return;
  regressions_.clear();
  const model::Interval thresholds = problem_.thresholds(trial);
  const CurveBasis basis(shape_, thresholds);
  const model::OutputCreep creep(creep_of(trial.creep_per_decade));
  for (std::size_t i = 0; i < problem_.excerpts.size(); ++i) {
    const Dataset dataset = problem_.excerpts[i].delayed_by(trial.delay_s, creep);
    const InitialMemory& memory = trial.memories[i];
    Path path = trace(thresholds, memory.origin(), prehistory(memory, thresholds, dataset.input.front()),
                      dataset.input);
    regressions_.emplace_back(std::move(path), basis, dataset, problem_.folds, nuisances(i));
  }
  prepared_ = trial;
}

// Returns the normal equations of each fold. Their unknowns are, in this order: the coefficients theta of the
// curves, the coefficients of the regressors, then offset and drift of each dataset.
std::vector<NormalEquations> SeparableFit::systems(const Trial& trial) {
  prepare(trial);
  const Eigen::Index n = shared_unknowns();
  Eigen::Index unknowns = n;
  for (const Regression& regression : regressions_) unknowns += regression.unknowns() - n;
  const auto count = static_cast<std::size_t>(problem_.folds);
  std::vector<NormalEquations> folds(count, NormalEquations(unknowns));
  const Pace pace = pace_of(trial, problem_.thresholds(trial));
  Eigen::Index at = n;
  for (const Regression& regression : regressions_) {
    const Eigen::Index own = regression.unknowns() - n;
    const double gain = trial.gain(static_cast<std::size_t>(&regression - regressions_.data()));
    if (own == 0 && unknowns == n && gain == 1.0) {
      regression.add(pace, folds);
      continue;
    }
    std::vector<NormalEquations> part(count, NormalEquations(n + own));
    regression.add(pace, part);
    for (std::size_t fold = 0; fold < count; ++fold) {
      part[fold].divide_outputs(gain);
      folds[fold].add(part[fold], n, at);
    }
    at += own;
  }
  return folds;
}

ValidCurves::Solution SeparableFit::solve(const NormalEquations& system, const Trial& trial, double limit) {
  const model::Interval thresholds = problem_.thresholds(trial);
  return curves_.solve(system, thresholds, pace_of(trial, thresholds), problem_.output_span,
                       problem_.observed.span(), limit);
}

Fitted SeparableFit::fit(const Trial& trial, double limit) {
  const NormalEquations all = sum_of(systems(trial));
  if (!all.is_finite()) return not_fitted();
  const Eliminated system(all, curve_unknowns());
  const ValidCurves::Solution solution = solve(system.rest(), trial, limit);
  return solution.beyond_limit ? not_fitted() : fitted(system, all.samples, solution, trial);
}

Fitted SeparableFit::fitted(const Eliminated& system, double samples, const ValidCurves::Solution& solution,
                            const Trial& trial) const {
  Fitted fitted;
  fitted.parameters = curves_.basis().parameters(solution.theta, pace_of(trial, problem_.thresholds(trial)));
  fitted.parameters.symmetry = problem_.symmetry;
  fitted.rms = std::sqrt(system.rest().residual_square(solution.theta) / samples);
  fitted.valid = solution.valid;
  fitted.violation = solution.violation;
  const Eigen::VectorXd completed = system.completed(solution.theta);
  Eigen::Index at = shared_unknowns();
  for (std::size_t i = 0; i < problem_.excerpts.size(); ++i) {
    fitted.offsets.push_back(nuisances(i).offset ? trial.gain(i) * completed[at++] : 0.0);
    fitted.drifts.push_back(nuisances(i).drift ? trial.gain(i) * completed[at++] : 0.0);
  }
  return fitted;
}

std::vector<LeftOut> SeparableFit::left_out(const Trial& trial) {
  std::vector<NormalEquations> folds = systems(trial);
  const NormalEquations all = sum_of(folds);
  std::vector<LeftOut> parts;
  if (!all.is_finite()) return parts;
  for (std::size_t i = 1; i < folds.size(); ++i) {
    NormalEquations rest = all;
    rest.take_away(folds[i], problem_.whole_excerpts ? 1.0 - kept_of_a_record : 1.0);
    const Eliminated system(rest, curve_unknowns());
    const Eigen::VectorXd completed = system.completed(solve(system.rest(), trial).theta);
    if (problem_.whole_excerpts)
      folds[i].divide_outputs(mean_gain_of_others(trial, i - 1) / trial.gain(i - 1));
    parts.push_back(judged(folds[i], completed.head(shared_unknowns())));
  }
  return parts;
}

// Returns the errors of a fold, predicted by a fit to the other folds. `shared`: the coefficients of the
// curves and of the regressors in this fit. Offset and drift of the fold do not count as errors. The first
// dataset has no unknown offset: its offset is the constant part of the curves. If offsets are fitted, an
// error in this constant part therefore does not count either.
LeftOut SeparableFit::judged(const NormalEquations& fold, const Eigen::VectorXd& shared) const {
  NormalEquations own = Eliminated(fold, shared_unknowns()).rest();
  if (std::ranges::any_of(problem_.nuisances, &Nuisances::offset)) {
    Eigen::VectorXd constant = Eigen::VectorXd::Zero(shared.size());
    constant.head(curve_unknowns()) = curves_.basis().constant();
    own.leave_out(constant);
  }
  const double square = shared.dot(own.H * shared);
  return {own.residual_square(shared), own.samples, square > 0.0 ? shared.dot(own.g) / square : 1.0};
}

std::optional<double> SeparableFit::held_out(const Trial& trial) {
  if (problem_.folds < 2) return std::nullopt;
  const std::vector<LeftOut> parts = left_out(trial);
  if (parts.empty()) return std::numeric_limits<double>::infinity();
  LeftOut sum;
  for (const LeftOut& part : parts) {
    sum.square += part.square;
    sum.samples += part.samples;
  }
  return sum.samples > 0.0 ? std::optional(sum.rms()) : std::nullopt;
}

}  // namespace hystcan::identification
