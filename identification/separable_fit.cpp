#include "identification/separable_fit.h"

#include <cmath>

namespace hystcan::identification {
namespace {

bool same_path(const Trial& a, const Trial& b) {
  const auto same = [](const InitialMemory& x, const InitialMemory& y) {
    return x.kind == y.kind && x.bias == y.bias;
  };
  return a.below == b.below && a.above == b.above && a.delay_s == b.delay_s &&
         std::equal(a.memories.begin(), a.memories.end(), b.memories.begin(), b.memories.end(), same);
}

Pace pace_of(const Trial& trial, model::Interval thresholds) {
  return {trial.k_span_ascending / thresholds.span(), trial.k_span_descending / thresholds.span()};
}

}  // namespace

model::Interval Problem::thresholds(const Trial& trial) const {
  const double span = observed.span();
  return {observed.lo - trial.below * span, observed.hi + trial.above * span};
}

SeparableFit::SeparableFit(const Problem& problem, int order, Scan scan)
    : problem_(problem), order_(order), curves_(order, static_cast<std::size_t>(scan)) {}

void SeparableFit::prepare(const Trial& trial) {
  if (prepared_ && same_path(*prepared_, trial)) return;
  regressions_.clear();
  const model::Interval thresholds = problem_.thresholds(trial);
  for (std::size_t i = 0; i < problem_.excerpts.size(); ++i) {
    const Excerpt::Sequence dataset = problem_.excerpts[i].delayed_by(trial.delay_s);
    const InitialMemory& memory = trial.memories[i];
    Path path = trace(thresholds, memory.origin(), prehistory(memory, thresholds, dataset.input.front()),
                      dataset.input);
    regressions_.emplace_back(std::move(path), thresholds, order_, dataset.input, dataset.output,
                              dataset.fold, problem_.folds);
  }
  prepared_ = trial;
}

std::vector<NormalEquations> SeparableFit::systems(const Trial& trial) {
  prepare(trial);
  std::vector<NormalEquations> folds(static_cast<std::size_t>(problem_.folds),
                                     NormalEquations(regressions_.front().unknowns()));
  const Pace pace = pace_of(trial, problem_.thresholds(trial));
  for (const Regression& regression : regressions_) regression.add(pace, folds);
  return folds;
}

ValidCurves::Solution SeparableFit::solve(const NormalEquations& system, const Trial& trial) {
  const model::Interval thresholds = problem_.thresholds(trial);
  return curves_.solve(system, thresholds, pace_of(trial, thresholds), problem_.output_span,
                       problem_.observed.span());
}

Fitted SeparableFit::fit(const Trial& trial) {
  const std::vector<NormalEquations> folds = systems(trial);
  NormalEquations all = folds.front();
  for (std::size_t i = 1; i < folds.size(); ++i) all += folds[i];
  const ValidCurves::Solution solution = solve(all, trial);
  const model::Interval thresholds = problem_.thresholds(trial);
  Fitted fitted;
  fitted.parameters = parameters_of(solution.theta, thresholds, pace_of(trial, thresholds));
  fitted.parameters.symmetry = problem_.symmetry;
  fitted.rms = std::sqrt(all.residual_square(solution.theta) / all.samples);
  fitted.valid = solution.valid;
  fitted.violation = solution.violation;
  return fitted;
}

std::optional<double> SeparableFit::held_out(const Trial& trial) {
  const std::vector<NormalEquations> folds = systems(trial);
  if (folds.size() < 2) return std::nullopt;
  NormalEquations all = folds.front();
  for (std::size_t i = 1; i < folds.size(); ++i) all += folds[i];
  double square = 0.0, samples = 0.0;
  for (std::size_t i = 1; i < folds.size(); ++i) {
    NormalEquations rest = all;
    rest -= folds[i];
    square += folds[i].residual_square(solve(rest, trial).theta);
    samples += folds[i].samples;
  }
  if (samples == 0.0) return std::nullopt;
  return std::sqrt(square / samples);
}

}  // namespace hystcan::identification
