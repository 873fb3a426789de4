#include "identification/dataset.h"

#include <algorithm>
#include <cmath>

#include "identification/regression.h"

namespace hystcan::identification {
namespace {

constexpr std::size_t most_turning_points = 2000;  // maximum number of turning points in a search

// Minimum swing of the input that counts as a cycle, as a share of its range.
constexpr double least_swing_of_range = 0.02;
// A cycle reaches an end of the input range if its distance from this end is at most this share of the range.
constexpr double at_the_end = 0.01;
constexpr int most_folds = 4;  // maximum number of folds in addition to fold 0

// Returns the number of the cycle to which each sample belongs. The first cycle has the number `first`.
std::vector<std::size_t> cycles_of(const Dataset& dataset, double swing, std::size_t first) {
  const std::vector<std::size_t> points = turning_points(dataset, swing);
  const auto input = [&](std::size_t point) { return dataset.input[points[point]]; };
  std::vector<std::size_t> cycle(dataset.size());
  std::size_t passed = 0, now = first;
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    for (; passed < points.size() && points[passed] < i; ++passed) {
      const bool lower = passed + 1 < points.size() ? input(passed) < input(passed + 1)
                         : passed > 0               ? input(passed) < input(passed - 1)
                                                    : false;
      if (lower) ++now;
    }
    cycle[i] = now;
  }
  return cycle;
}

struct Cycles {
  // For each dataset, the cycle of each sample. The numbers continue from one dataset to the next.
  std::vector<std::vector<std::size_t>> of;
  std::vector<model::Interval> reach;  // lowest and highest input of each cycle

  Cycles(const std::vector<Dataset>& datasets, model::Interval observed) {
    std::size_t count = 0;
    for (const Dataset& dataset : datasets) {
      of.push_back(cycles_of(dataset, least_swing_of_range * observed.span(), count));
      count = of.back().back() + 1;
    }
    reach.assign(count, {observed.hi, observed.lo});
    for (std::size_t r = 0; r < datasets.size(); ++r)
      for (std::size_t i = 0; i < datasets[r].size(); ++i) {
        model::Interval& of_cycle = reach[of[r][i]];
        of_cycle.lo = std::min(of_cycle.lo, datasets[r].input[i]);
        of_cycle.hi = std::max(of_cycle.hi, datasets[r].input[i]);
      }
  }

  Folds folds(const std::vector<int>& fold_of_cycle, int count) const {
    Folds folds{.of = {}, .count = count, .cycles = reach.size()};
    for (const auto& cycles : of) {
      folds.of.emplace_back();
      for (const std::size_t c : cycles) folds.of.back().push_back(fold_of_cycle[c]);
    }
    return folds;
  }
};

}  // namespace

model::Interval range_of(const std::vector<double>& values) {
  const auto [low, high] = std::ranges::minmax_element(values);
  return {*low, *high};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

std::vector<std::size_t> turning_points(const Dataset& dataset, double least_swing) {
  std::vector<std::size_t> points;
  if (dataset.size() == 0) return points;
  std::size_t low = 0, high = 0;  // samples with the extreme inputs since the last turning point
  int direction = 0;
  for (std::size_t i = 1; i < dataset.size(); ++i) {
    const double v = dataset.input[i];
    if (v < dataset.input[low]) low = i;
    if (v > dataset.input[high]) high = i;
    if (direction <= 0 && v - dataset.input[low] > least_swing) {
      if (direction < 0) points.push_back(low);
      direction = 1;
      high = low = i;
    } else if (direction >= 0 && dataset.input[high] - v > least_swing) {
      if (direction > 0) points.push_back(high);
      direction = -1;
      high = low = i;
    }
  }
  return points;
}

double least_swing(const Dataset& dataset, double span) {
  double swing = 1e-5 * span;
  while (turning_points(dataset, swing).size() > most_turning_points) swing *= 2.0;
  return swing;
}

std::vector<HalfCycle> half_cycles(const Dataset& dataset, double least_swing) {
  std::vector<HalfCycle> halves;
  std::size_t begin = 0;
  for (const std::size_t i : turning_points(dataset, least_swing)) {
    halves.push_back({begin, i + 1, dataset.input[begin], dataset.input[i]});
    begin = i;
  }
  halves.push_back({begin, dataset.size(), dataset.input[begin], dataset.input.back()});
  return halves;
}

Dataset folded(const Dataset& dataset) {
  Dataset folded = dataset;
  for (double& v : folded.input) v = std::abs(v);
  return folded;
}

Folds assign_folds(const std::vector<Dataset>& datasets, model::Interval observed) {
  const Cycles cycles(datasets, observed);
  const auto& reach = cycles.reach;
  const double near = at_the_end * observed.span();
  const auto lowest = std::ranges::find_if(reach, [&](auto range) { return range.lo <= observed.lo + near; });
  const auto highest =
      std::ranges::find_if(reach, [&](auto range) { return range.hi >= observed.hi - near; });
  std::vector<int> fold_of_cycle(reach.size(), 0);
  int assigned = 0;
  for (std::size_t c = 0; c < reach.size(); ++c)
    if (c != static_cast<std::size_t>(lowest - reach.begin()) &&
        c != static_cast<std::size_t>(highest - reach.begin()))
      fold_of_cycle[c] = 1 + assigned++ % most_folds;
  return cycles.folds(fold_of_cycle, 1 + std::min(assigned, most_folds));
}

Folds records_as_folds(const std::vector<Dataset>& datasets, model::Interval observed) {
  const Cycles cycles(datasets, observed);
  const double near = at_the_end * observed.span();
  std::vector<model::Interval> ranges;
  ranges.reserve(datasets.size());
  for (const Dataset& dataset : datasets) ranges.push_back(range_of(dataset.input));
  std::vector<int> fold_of_cycle(cycles.reach.size(), 0);
  for (std::size_t r = 0; r < datasets.size(); ++r) {
    model::Interval others{observed.hi, observed.lo};
    for (std::size_t other = 0; other < ranges.size(); ++other)
      if (other != r) others = {std::min(others.lo, ranges[other].lo), std::max(others.hi, ranges[other].hi)};
    for (std::size_t c = cycles.of[r].front(); c <= cycles.of[r].back(); ++c)
      if (cycles.reach[c].lo >= others.lo - near && cycles.reach[c].hi <= others.hi + near)
        fold_of_cycle[c] = static_cast<int>(r) + 1;
  }
  return cycles.folds(fold_of_cycle, static_cast<int>(datasets.size()) + 1);
}

}  // namespace hystcan::identification
