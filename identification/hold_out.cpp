#include "identification/hold_out.h"

#include <algorithm>

#include "identification/excerpt.h"

namespace hystcan::identification {
namespace {

constexpr double least_swing_of_range = 0.02;  // of the range
constexpr double at_the_end = 0.01;            // of the range
constexpr int most_folds = 4;                  // without fold 0

// The number of the cycle of each sample, counted from `first`.
std::vector<std::size_t> cycles_of(const Dataset& dataset, double swing, std::size_t first) {
  const std::vector<TurningPoint> points = turning_points(dataset, swing);
  std::vector<std::size_t> cycle(dataset.size());
  std::size_t passed = 0, now = first;
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    for (; passed < points.size() && points[passed].time_s < dataset.time_s[i]; ++passed) {
      const bool lower = passed + 1 < points.size() ? points[passed].input < points[passed + 1].input
                         : passed > 0               ? points[passed].input < points[passed - 1].input
                                                    : false;
      if (lower) ++now;
    }
    cycle[i] = now;
  }
  return cycle;
}

}  // namespace

Folds assign_folds(const std::vector<Dataset>& datasets, model::Interval observed) {
  std::vector<std::vector<std::size_t>> cycle;
  Folds folds;
  for (const Dataset& dataset : datasets) {
    cycle.push_back(cycles_of(dataset, least_swing_of_range * observed.span(), folds.cycles));
    folds.cycles = cycle.back().back() + 1;
  }
  std::vector<model::Interval> reach(folds.cycles, {observed.hi, observed.lo});
  for (std::size_t r = 0; r < datasets.size(); ++r)
    for (std::size_t i = 0; i < datasets[r].size(); ++i) {
      model::Interval& of_cycle = reach[cycle[r][i]];
      of_cycle.lo = std::min(of_cycle.lo, datasets[r].input[i]);
      of_cycle.hi = std::max(of_cycle.hi, datasets[r].input[i]);
    }
  const double near = at_the_end * observed.span();
  const auto lowest = std::ranges::find_if(reach, [&](auto range) { return range.lo <= observed.lo + near; });
  const auto highest =
      std::ranges::find_if(reach, [&](auto range) { return range.hi >= observed.hi - near; });
  std::vector<int> fold_of_cycle(folds.cycles, 0);
  int assigned = 0;
  for (std::size_t c = 0; c < folds.cycles; ++c)
    if (c != static_cast<std::size_t>(lowest - reach.begin()) &&
        c != static_cast<std::size_t>(highest - reach.begin()))
      fold_of_cycle[c] = 1 + assigned++ % most_folds;
  folds.count = 1 + std::min(assigned, most_folds);
  for (const auto& cycles : cycle) {
    folds.of.emplace_back();
    for (const std::size_t c : cycles) folds.of.back().push_back(fold_of_cycle[c]);
  }
  return folds;
}

}  // namespace hystcan::identification
