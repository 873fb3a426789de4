#include "identification/delay_range.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "identification/numerics/nelder_mead.h"
#include "identification/prediction.h"

namespace hystcan::identification {
namespace {

constexpr double delay_as_good = 1.1;  // times the best error
constexpr int k_evaluations = 60;

struct End {
  double delay_s = 0.0;
  Fitted fitted;
};

class Delays {
 public:
  Delays(const Problem& problem, const SearchResult& found, const std::function<bool()>& go_on)
      : trial_(found.trial),
        fit_(problem, found.shape, SeparableFit::Scan::coarse),
        fine_(problem, found.shape, SeparableFit::Scan::fine),
        go_on_(go_on) {
    largest_rms_ = delay_as_good * fit_.fit(trial_).rms;
  }

  /// The last delay in this direction that is as good, to a quarter of the step, and its model.
  End farthest(double step_s) {
    Trial last = trial_;
    double beyond_s = 0.0;  // from the best delay: not as good
    const auto try_at = [&](double from_best_s) {
      Trial next = last;
      next.delay_s = std::max(0.0, trial_.delay_s + from_best_s);
      if (with_best_k(next) > largest_rms_) return false;
      last = next;
      return true;
    };
    for (double step = step_s; go_on_() && std::abs(step) < 40.0 * std::abs(step_s); step *= 1.5) {
      if (!try_at(step)) {
        beyond_s = step;
        break;
      }
      if (last.delay_s == 0.0) break;
    }
    while (beyond_s != 0.0 && go_on_()) {
      const double as_good_s = last.delay_s - trial_.delay_s;
      if (std::abs(beyond_s - as_good_s) < 0.25 * std::abs(step_s)) break;
      const double middle = as_good_s + 0.5 * (beyond_s - as_good_s);
      if (!try_at(middle)) beyond_s = middle;
    }
    return {last.delay_s, fine_.fit(last)};
  }

 private:
  double with_best_k(Trial& trial) {
    Eigen::VectorXd start(2);
    start << std::asinh(trial.k_span_ascending), std::asinh(trial.k_span_descending);
    const auto at = [&](const Eigen::VectorXd& x) {
      Trial moved = trial;
      moved.k_span_ascending = std::sinh(x[0]);
      moved.k_span_descending = std::sinh(x[1]);
      return moved;
    };
    const auto cost = [&](const Eigen::VectorXd& x) {
      const Fitted fitted = fit_.fit(at(x));
      return fitted.valid ? fitted.rms : 10.0 * largest_rms_;
    };
    const Minimum best = minimise(cost, start, Eigen::Vector2d(0.2, 0.2), 1e-3, k_evaluations, go_on_);
    trial = at(best.at);
    return best.value;
  }

  Trial trial_;
  SeparableFit fit_;
  SeparableFit fine_;  // for the models at the ends
  const std::function<bool()>& go_on_;
  double largest_rms_ = 0.0;
};

}  // namespace

std::optional<DelayRange> delay_range(const Problem& problem, const SearchResult& found,
                                      const std::vector<Dataset>& datasets,
                                      const std::function<bool()>& go_on) {
  double shortest_s = std::numeric_limits<double>::infinity();
  for (const Dataset& dataset : datasets)
    shortest_s = std::min(shortest_s, (dataset.time_s.back() - dataset.time_s.front()) /
                                          static_cast<double>(dataset.size() - 1));
  Delays delays(problem, found, go_on);
  const double step_s = std::max(0.1 * shortest_s, 0.05 * found.trial.delay_s);
  const End low = delays.farthest(-step_s);
  const End high = delays.farthest(step_s);
  if (!low.fitted.valid || !high.fitted.valid) return std::nullopt;
  const auto first = model::Hysteresis::beyond_limit(low.fitted.parameters);
  const auto last = model::Hysteresis::beyond_limit(high.fitted.parameters);
  const auto difference = [&](double faster) {
    double square = 0.0, samples = 0.0;
    for (std::size_t i = 0; i < datasets.size() && go_on(); ++i) {
      Dataset fast = datasets[i];
      for (double& t : fast.time_s) t /= faster;
      const auto a = predict(first, fast, {low.delay_s, {}, creep_of(found.trial)}, found.trial.memories[i]);
      const auto b = predict(last, fast, {high.delay_s, {}, creep_of(found.trial)}, found.trial.memories[i]);
      const ErrorNorms norms = ErrorNorms::of(a, b);
      square += norms.rms * norms.rms * static_cast<double>(a.size());
      samples += static_cast<double>(a.size());
    }
    return std::sqrt(square / samples);
  };
  const DelayRange range{low.delay_s, high.delay_s, difference(2.0), difference(5.0)};
  return go_on() ? std::optional(range) : std::nullopt;
}

}  // namespace hystcan::identification
