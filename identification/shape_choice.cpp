#include "identification/shape_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <utility>

namespace hystcan::identification {
namespace {

constexpr std::size_t most_cells = 400;

// Divides the input range into cells (intervals of the input) that contain about the same number of samples.
// Returns the borders of the cells; the first and the last border are the ends of the range.
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

// Distributes `amount` over the cells (intervals of the input) between the inputs a and b. Each cell gets a
// share in proportion to the length that it has in common with the interval from a to b.
void spread(const std::vector<double>& borders, double a, double b, double amount,
            std::vector<double>& cells) {
  const auto [lo, hi] = std::minmax(a, b);
  const auto first = std::upper_bound(borders.begin() + 1, borders.end() - 1, lo) - 1;
  for (auto border = first; border + 1 != borders.end() && *border < hi; ++border) {
    const double part = std::min(hi, *(border + 1)) - std::max(lo, *border);
    if (part > 0.0) cells[static_cast<std::size_t>(border - borders.begin())] += amount * part / (hi - lo);
  }
}

// Returns the mean change of the output across each cell (interval of the input). Rising and falling inputs
// are combined, so that noise cancels.
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

struct Sample {
  double input, output, weight;
};

// Sorts the samples by input and combines them into blocks, so that the mean output increases from block to
// block. Two neighbouring blocks are merged if the mean output does not increase between them.
std::vector<Sample> pooled(std::vector<Sample> samples) {
  std::ranges::sort(samples, {}, &Sample::input);
  std::vector<Sample> blocks;
  for (const Sample& sample : samples) {
    blocks.push_back(sample);
    while (blocks.size() > 1 && blocks[blocks.size() - 2].output >= blocks.back().output) {
      const Sample last = blocks.back();
      blocks.pop_back();
      Sample& before = blocks.back();
      const double weight = before.weight + last.weight, share = last.weight / weight;
      before = {before.input + share * (last.input - before.input),
                before.output + share * (last.output - before.output), weight};
    }
  }
  return blocks;
}

// Returns the output at an input, interpolated linearly between the points of `course`.
double output_at(const std::vector<Sample>& course, double input) {
  const auto after = std::ranges::lower_bound(course, input, {}, &Sample::input);
  if (after == course.begin()) return course.front().output;
  if (after == course.end()) return course.back().output;
  const Sample& before = *std::prev(after);
  const double part = (input - before.input) / (after->input - before.input);
  return before.output + part * (after->output - before.output);
}

}  // namespace

std::function<std::vector<double>(int)> knot_places(const std::vector<Dataset>& datasets,
                                                    model::Interval observed) {
  const std::vector<double> borders = quantiles(datasets, observed);
  std::vector<double> shares = output_ways(datasets, borders);
  const double total = std::reduce(shares.begin(), shares.end());
  const auto cells = static_cast<double>(shares.size());
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const double length = (borders[i + 1] - borders[i]) / observed.span();
    shares[i] = (length + 3.0 * (total > 0.0 ? shares[i] / total : length) + 2.0 / cells) / 6.0;
  }
  return [borders, shares](int pieces) {
    std::vector<double> knots{borders.front()};
    double passed = 0.0;
    std::size_t cell = 0;
    for (int i = 1; i < pieces; ++i) {
      const double wanted = static_cast<double>(i) / pieces;
      while (cell + 1 < shares.size() && passed + shares[cell] < wanted) passed += shares[cell++];
      const double in_cell = std::clamp((wanted - passed) / shares[cell], 0.0, 1.0);
      knots.push_back(borders[cell] + in_cell * (borders[cell + 1] - borders[cell]));
    }
    knots.push_back(borders.back());
    return knots;
  };
}

std::function<double(double)> mean_course(const Problem& problem, const Trial& trial,
                                          const std::vector<double>& offsets) {
  std::array<std::vector<Sample>, 2> samples;
  for (std::size_t i = 0; i < problem.excerpts.size(); ++i) {
    const Dataset sequence =
        problem.excerpts[i].delayed_by(trial.delay_s, model::OutputCreep(creep_of(trial.creep_per_decade)));
    std::size_t direction = 0;
    for (std::size_t j = 0; j < sequence.input.size(); ++j) {
      if (j > 0 && sequence.input[j] != sequence.input[j - 1])
        direction = sequence.input[j] > sequence.input[j - 1] ? 0 : 1;
      if (sequence.fold[j] != Regression::left_out && sequence.weight[j] > 0.0)
        samples[direction].push_back({sequence.input[j], (sequence.output[j] - offsets[i]) / trial.gain(i),
                                      sequence.weight[j] * sequence.weight[j]});
    }
  }
  return [rising = pooled(std::move(samples[0])), falling = pooled(std::move(samples[1]))](double input) {
    double sum = 0.0, count = 0.0;
    for (const auto* course : {&rising, &falling}) {
      if (course->empty()) continue;
      sum += output_at(*course, input);
      count += 1.0;
    }
    return sum / count;
  };
}

}  // namespace hystcan::identification
