#include "identification/valley.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "identification/numerics/nelder_mead.h"

namespace hystcan::identification {
namespace {

constexpr double nearly_best = 1.1;  // times the best error
constexpr int evaluations_of_each = 30;

}  // namespace

Valley::Valley(const Problem& problem, const SearchResult& found, double Trial::*number,
               Companions companions, const std::function<bool()>& go_on)
    : trial_(found.trial),
      number_(number),
      companions_(std::move(companions)),
      fit_(problem, found.shape, SeparableFit::Scan::coarse),
      go_on_(go_on) {
  largest_rms_ = nearly_best * fit_.fit(trial_).rms;
}

Trial Valley::farthest(double step) {
  Trial last = trial_;
  double beyond = 0.0;  // from the best value: not as good
  const auto try_at = [&](double from_best) {
    Trial next = last;
    next.*number_ = std::max(0.0, trial_.*number_ + from_best);
    if (!is_as_good(next)) return false;
    last = next;
    return true;
  };
  for (double way = step; go_on_() && std::abs(way) < 40.0 * std::abs(step); way *= 1.5) {
    if (!try_at(way)) {
      beyond = way;
      break;
    }
    if (last.*number_ == 0.0) break;
  }
  while (beyond != 0.0 && go_on_()) {
    const double good = last.*number_ - trial_.*number_;
    if (std::abs(beyond - good) < 0.25 * std::abs(step)) break;
    const double middle = good + 0.5 * (beyond - good);
    if (!try_at(middle)) beyond = middle;
  }
  return last;
}

bool Valley::is_as_good(Trial& trial) {
  std::vector<Unknown> moved = both_k(trial);
  for (Unknown& companion : companions_(trial)) moved.push_back(std::move(companion));
  Eigen::VectorXd start(std::ssize(moved));
  for (std::size_t i = 0; i < moved.size(); ++i) start[static_cast<Eigen::Index>(i)] = moved[i].start;
  const auto at = [&](const Eigen::VectorXd& x) {
    Trial there = trial;
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i].set(there, x[static_cast<Eigen::Index>(i)]);
    return there;
  };
  const auto cost = [&](const Eigen::VectorXd& x) {
    const Trial there = at(x);
    if (there.delay_s < 0.0) return 10.0 * largest_rms_;
    const Fitted fitted = fit_.fit(there);
    return fitted.valid ? fitted.rms : 10.0 * largest_rms_;
  };
  const Eigen::VectorXd steps = Eigen::VectorXd::Constant(start.size(), 0.2);
  const Minimum best =
      minimise(cost, start, steps, 1e-3, evaluations_of_each * static_cast<int>(moved.size()), go_on_);
  trial = at(best.at);
  return best.value <= largest_rms_;
}

}  // namespace hystcan::identification
