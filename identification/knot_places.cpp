#include "identification/knot_places.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hystcan::identification {
namespace {

constexpr std::size_t most_cells = 400;

// The ends of the range and quantiles of the inputs between them.
std::vector<double> quantiles(const std::vector<Dataset>& datasets, model::Interval observed) {
  std::vector<double> inputs;
  for (const Dataset& dataset : datasets)
    inputs.insert(inputs.end(), dataset.input.begin(), dataset.input.end());
  std::ranges::sort(inputs);
  std::vector<double> borders{observed.lo};
  const double least = 1e-7 * observed.span();
  for (std::size_t i = 1; i < most_cells; ++i) {
    const double border = inputs[i * (inputs.size() - 1) / most_cells];
    if (border > borders.back() + least && border < observed.hi - least) borders.push_back(border);
  }
  borders.push_back(observed.hi);
  return borders;
}

// Adds `amount` to the cells between two inputs, in proportion to their lengths.
void spread(const std::vector<double>& borders, double a, double b, double amount,
            std::vector<double>& cells) {
  const auto [lo, hi] = std::minmax(a, b);
  const auto first = std::upper_bound(borders.begin() + 1, borders.end() - 1, lo) - 1;
  for (auto border = first; border + 1 != borders.end() && *border < hi; ++border) {
    const double part = std::min(hi, *(border + 1)) - std::max(lo, *border);
    if (part > 0.0) cells[static_cast<std::size_t>(border - borders.begin())] += amount * part / (hi - lo);
  }
}

// The way that outputs go in each cell on average, up or down alike: noise cancels.
std::vector<double> output_ways(const std::vector<Dataset>& datasets, const std::vector<double>& borders) {
  std::vector<double> rise(borders.size() - 1, 0.0), run = rise;
  for (const Dataset& dataset : datasets)
    for (std::size_t i = 1; i < dataset.size(); ++i) {
      const double from = dataset.input[i - 1], to = dataset.input[i];
      if (from == to) continue;
      spread(borders, from, to, (dataset.output[i] - dataset.output[i - 1]) * (to > from ? 1.0 : -1.0), rise);
      spread(borders, from, to, std::abs(to - from), run);
    }
  for (std::size_t i = 0; i < rise.size(); ++i)
    rise[i] = run[i] > 0.0 ? std::max(0.0, rise[i] / run[i]) * (borders[i + 1] - borders[i]) : 0.0;
  return rise;
}

}  // namespace

KnotPlaces::KnotPlaces(const std::vector<Dataset>& datasets, model::Interval observed)
    : borders_(quantiles(datasets, observed)), share_(output_ways(datasets, borders_)) {
  const double way = std::reduce(share_.begin(), share_.end());
  const auto cells = static_cast<double>(share_.size());
  for (std::size_t i = 0; i < share_.size(); ++i) {
    const double length = (borders_[i + 1] - borders_[i]) / observed.span();
    share_[i] = (length + 3.0 * (way > 0.0 ? share_[i] / way : length) + 2.0 / cells) / 6.0;
  }
}

std::vector<double> KnotPlaces::knots(int pieces) const {
  std::vector<double> knots{borders_.front()};
  double passed = 0.0;
  std::size_t cell = 0;
  for (int i = 1; i < pieces; ++i) {
    const double wanted = static_cast<double>(i) / pieces;
    while (cell + 1 < share_.size() && passed + share_[cell] < wanted) passed += share_[cell++];
    const double in_cell = std::clamp((wanted - passed) / share_[cell], 0.0, 1.0);
    knots.push_back(borders_[cell] + in_cell * (borders_[cell + 1] - borders_[cell]));
  }
  knots.push_back(borders_.back());
  return knots;
}

}  // namespace hystcan::identification
