#include "identification/determination.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "identification/butterfly.h"
#include "identification/identify.h"
#include "identification/numerics/nonlinear_fit.h"
#include "identification/output_reference.h"
#include "identification/quasi_static.h"
#include "identification/regression.h"
#include "identification/unknowns.h"

namespace hystcan::identification {
namespace {

constexpr double nearly_best = 1.1;  // an RMS error up to this multiple of the smallest one is as good
constexpr int evaluations_of_each = 30;

// Finds how far one parameter of the best model (`number`: its creep or its delay) can move before the error
// exceeds 1.1 times the error of that model. After each move, the parameters that can compensate the move get
// their best values: both convergence rates, and the delay if it is not the moved parameter.
class Valley {
 public:
  Valley(const Problem& problem, const SearchResult& found, double Trial::*number, model::Interval allowed,
         const std::function<bool()>& go_on)
      : trial_(found.trial),
        number_(number),
        allowed_(allowed),
        fit_(problem, found.shape, SeparableFit::coarse_scan),
        go_on_(go_on),
        largest_rms_(nearly_best * fit_.fit(trial_).rms) {}

  // Moves the parameter `number_` of the trial in the direction of `step`. Returns the trial that moved
  // farthest with an error of at most 1.1 times the smallest error. The resolution is a quarter of the step.
  Trial farthest(double step) {
    Trial last = trial_;
    // Smallest known distance of the parameter `number_` from its best value at which the error exceeds 1.1
    // times the smallest error; 0: no such distance is known.
    double beyond = 0.0;
    const auto try_at = [&](double from_best) {
      Trial next = last;
      next.*number_ = std::clamp(trial_.*number_ + from_best, allowed_.lo, allowed_.hi);
      if (!is_as_good(next)) return false;
      last = next;
      return true;
    };
    for (double way = step; go_on_() && std::abs(way) < 40.0 * std::abs(step); way *= 1.5) {
      if (!try_at(way)) {
        beyond = way;
        break;
      }
      if (last.*number_ == allowed_.lo || last.*number_ == allowed_.hi) break;
    }
    while (beyond != 0.0 && go_on_()) {
      const double good = last.*number_ - trial_.*number_;
      if (std::abs(beyond - good) < 0.25 * std::abs(step)) break;
      const double middle = good + 0.5 * (beyond - good);
      if (!try_at(middle)) beyond = middle;
    }
    return last;
  }

 private:
  bool is_as_good(Trial& trial) {
    std::vector<Unknown> moved = both_k(trial);
    if (number_ != &Trial::delay_s && trial.delay_s > 0.0) moved.push_back(delay_of(trial.delay_s));
    const Eigen::VectorXd start = numbers_of(moved, &Unknown::start);
    const auto cost = [&](const Eigen::VectorXd& x, double limit) {
      const Trial candidate = moved_to(x, moved, trial);
      if (candidate.delay_s < 0.0) return 10.0 * largest_rms_;
      const Fitted fitted = fit_.fit(candidate, limit);
      return fitted.valid ? fitted.rms : 10.0 * largest_rms_;
    };
    const Eigen::VectorXd steps = Eigen::VectorXd::Constant(start.size(), 0.2);
    const Minimum best =
        minimise(cost, start, steps, 1e-3, evaluations_of_each * static_cast<int>(moved.size()), go_on_);
    trial = moved_to(best.x, moved, trial);
    return best.value <= largest_rms_;
  }

  Trial trial_;
  double Trial::*number_;
  model::Interval allowed_;
  SeparableFit fit_;
  const std::function<bool()>& go_on_;
  double largest_rms_;
};

}  // namespace

// From the best convergence rate, tries smaller rates and then larger rates, at distances that grow by half
// from try to try. Each end of the range is the last rate before the error exceeds the limit.
model::Interval pace_range(const Problem& problem, const SearchResult& found, double Trial::*k,
                           const std::function<bool()>& go_on) {
  SeparableFit fit(problem, found.shape, SeparableFit::coarse_scan);
  Trial trial = found.trial;
  const double best = trial.*k, largest_rms = 1.05 * fit.fit(trial).rms;
  const auto is_as_good = [&](double value) {
    trial.*k = value;
    const Fitted fitted = fit.fit(trial, largest_rms);
    return fitted.valid && fitted.rms <= largest_rms;
  };
  const double scale = std::max(std::abs(best), 0.03);
  const auto farthest = [&](double way) {
    double last = best, step = 0.05 * scale;
    for (int i = 0; i < 19 && go_on() && is_as_good(best + way * step); ++i, step *= 1.5)
      last = best + way * step;
    return last;
  };
  const double lo = farthest(-1.0), hi = farthest(1.0);
  const double span = problem.thresholds(trial).span();
  return {lo / span, hi / span};
}

bool is_determined(model::Interval pace) {
  return pace.lo * pace.hi > 0.0 && std::max(pace.lo / pace.hi, pace.hi / pace.lo) < 10.0;
}

model::Interval creep_range(const Problem& problem, const SearchResult& found,
                            const std::function<bool()>& go_on) {
  Valley valley(problem, found, &Trial::creep_per_decade, {0.0, most_creep_per_decade}, go_on);
  const double step = 0.1 * found.trial.creep_per_decade;
  return {valley.farthest(-step).creep_per_decade, valley.farthest(step).creep_per_decade};
}

std::optional<GainsInstead> gains_instead_of_creep(const Problem& problem, const SearchResult& found,
                                                   const std::function<bool()>& go_on) {
  SeparableFit fit(problem, found.shape, SeparableFit::coarse_scan);
  GainsInstead instead{.gains = {}, .rms = 0.0, .rms_with_creep = fit.fit(found.trial).rms};
  Trial trial = found.trial;
  trial.creep_per_decade = 0.0;
  std::vector<Unknown> moved = both_k(trial);
  if (trial.delay_s > 0.0) moved.push_back(delay_of(trial.delay_s));
  for (std::size_t i = 1; i < trial.memories.size(); ++i) moved.push_back(gain_of(i, trial.gain(i)));
  const auto cost = [&](const Eigen::VectorXd& x, double limit) {
    const Trial candidate = moved_to(x, moved, trial);
    const Fitted fitted = candidate.delay_s < 0.0 ? Fitted{} : fit.fit(candidate, limit);
    return fitted.valid ? fitted.rms : 10.0 * problem.output_span;
  };
  const Eigen::VectorXd start = numbers_of(moved, &Unknown::start);
  const Minimum best = minimise(cost, start, Eigen::VectorXd::Constant(start.size(), 0.2), 1e-4,
                                2 * evaluations_of_each * static_cast<int>(moved.size()), go_on);
  trial = moved_to(best.x, moved, trial);
  instead.rms = best.value;
  for (std::size_t i = 0; i < trial.memories.size(); ++i) instead.gains.push_back(trial.gain(i));
  return best.value <= nearly_best * instead.rms_with_creep ? std::optional(instead) : std::nullopt;
}

std::optional<DelayRange> delay_range(const Problem& problem, const SearchResult& found,
                                      const std::vector<Dataset>& datasets,
                                      const std::function<bool()>& go_on) {
  double shortest_s = std::numeric_limits<double>::infinity();
  for (const Dataset& dataset : datasets)
    shortest_s = std::min(shortest_s, (dataset.time_s.back() - dataset.time_s.front()) /
                                          static_cast<double>(dataset.size() - 1));
  Valley valley(problem, found, &Trial::delay_s, {0.0, std::numeric_limits<double>::infinity()}, go_on);
  const double step_s = std::max(0.1 * shortest_s, 0.05 * found.trial.delay_s);
  const Trial low = valley.farthest(-step_s), high = valley.farthest(step_s);
  SeparableFit fine(problem, found.shape, SeparableFit::fine_scan);
  const Fitted of_low = fine.fit(low), of_high = fine.fit(high);
  if (!of_low.valid || !of_high.valid) return std::nullopt;
  const auto first = model::Hysteresis::beyond_limit(of_low.parameters);
  const auto last = model::Hysteresis::beyond_limit(of_high.parameters);
  const auto difference = [&](double faster) {
    double square = 0.0, samples = 0.0;
    for (std::size_t i = 0; i < datasets.size() && go_on(); ++i) {
      Dataset fast = datasets[i];
      for (double& t : fast.time_s) t /= faster;
      const auto a = predict(first, fast, {low.delay_s, {}, creep_of(found.trial.creep_per_decade)},
                             found.trial.memories[i]);
      const auto b = predict(last, fast, {high.delay_s, {}, creep_of(found.trial.creep_per_decade)},
                             found.trial.memories[i]);
      const ErrorNorms norms = ErrorNorms::of(a, b);
      square += norms.rms * norms.rms * static_cast<double>(a.size());
      samples += static_cast<double>(a.size());
    }
    return std::sqrt(square / samples);
  };
  const DelayRange range{low.delay_s, high.delay_s, difference(2.0), difference(5.0)};
  return go_on() ? std::optional(range) : std::nullopt;
}

Landscape landscape(const std::vector<Dataset>& datasets, const Identified& identified, int points) {
  std::vector<Dataset> seen;
  seen.reserve(datasets.size());
  const std::vector<Dataset> still = identified.dynamics ? without_dynamics(datasets, identified) : datasets;
  for (const Dataset& dataset : identified.parameters.output_map ? linearised(still, identified) : still)
    seen.push_back(identified.parameters.symmetry == model::Symmetry::even ? folded(dataset) : dataset);
  const bool one_zero = std::ranges::all_of(identified.offsets, [](double zero) { return zero == 0.0; });
  move_outputs(seen, reference_outputs(seen, one_zero), -1.0);
  Problem problem;
  problem.observed = identified.observed;
  problem.symmetry = identified.parameters.symmetry;
  problem.output_span = identified.output_span;
  for (const Dataset& dataset : seen)
    problem.excerpts.emplace_back(dataset, std::vector<int>{}, 1000,
                                  least_swing(dataset, problem.observed.span()));
  for (std::size_t i = 0; i < datasets.size(); ++i)
    problem.nuisances.push_back({identified.offsets[i] != 0.0, identified.drifts[i] != 0.0});
  problem.regressors = static_cast<Eigen::Index>(seen.front().regressors.size());
  SeparableFit fit(problem, identified.search.shape, SeparableFit::coarse_scan);
  const double span = identified.parameters.input_range().span();
  const auto grid = [&](double best) {
    const double middle = std::asinh(best * span);
    std::vector<double> values;
    values.reserve(static_cast<std::size_t>(points));
    for (int i = 0; i < points; ++i)
      values.push_back(std::sinh(middle + 2.0 * (2.0 * i / (points - 1.0) - 1.0)) / span);
    return values;
  };
  Landscape map;
  map.k_ascending = grid(identified.parameters.k_ascending);
  map.k_descending = grid(identified.parameters.k_descending);
  Trial trial = identified.search.trial;
  for (const double descending : map.k_descending) {
    map.rms.emplace_back();
    for (const double ascending : map.k_ascending) {
      trial.k_span_ascending = ascending * span;
      trial.k_span_descending = descending * span;
      map.rms.back().push_back(fit.fit(trial).rms);
    }
  }
  return map;
}

}  // namespace hystcan::identification
