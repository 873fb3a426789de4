#include "identification/memory_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hystcan::identification {
namespace {

constexpr double bias_step = 0.5;  // on the grid
constexpr int widest_bias = 10;    // in steps

class Estimator {
 public:
  Estimator(const model::Hysteresis& model, Dataset beginning, const Lag& lag, bool with_offset)
      : model_(model), beginning_(std::move(beginning)), lag_(lag), with_offset_(with_offset) {}

  MemoryEstimate estimate_with(const InitialMemory& memory) const {
    const std::vector<double> predicted = predict(model_, beginning_, lag_, memory);
    MemoryEstimate estimate{memory, 0.0, 0.0};
    const auto count = static_cast<double>(predicted.size());
    if (with_offset_)
      for (std::size_t i = 0; i < predicted.size(); ++i)
        estimate.offset += (beginning_.output[i] - predicted[i]) / count;
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      const double error = beginning_.output[i] - predicted[i] - estimate.offset;
      estimate.rms += error * error / count;
    }
    estimate.rms = std::sqrt(estimate.rms);
    return estimate;
  }

  // Searches a grid, then does a golden section search around its best bias.
  MemoryEstimate best_bias() const {
    using Kind = InitialMemory::Kind;
    MemoryEstimate best{{}, 0.0, std::numeric_limits<double>::infinity()};
    for (int i = -widest_bias; i <= widest_bias; ++i)
      if (const auto now = estimate_with({Kind::nested, i * bias_step}); now.rms < best.rms) best = now;
    double lo = best.memory.bias - bias_step, hi = best.memory.bias + bias_step;
    const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
    while (hi - lo > 1e-4) {
      const auto left = estimate_with({Kind::nested, hi - golden * (hi - lo)});
      const auto right = estimate_with({Kind::nested, lo + golden * (hi - lo)});
      for (const auto& now : {left, right})
        if (now.rms < best.rms) best = now;
      (left.rms < right.rms ? hi : lo) = left.rms < right.rms ? right.memory.bias : left.memory.bias;
    }
    return best;
  }

 private:
  const model::Hysteresis& model_;
  Dataset beginning_;
  Lag lag_;
  bool with_offset_;
};

Dataset beginning_of(const Dataset& dataset, std::size_t samples) {
  Dataset beginning = dataset;
  for (auto* column : {&beginning.time_s, &beginning.input, &beginning.output}) column->resize(samples);
  return beginning;
}

}  // namespace

MemoryEstimate estimate_memory(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                               std::size_t samples, bool with_offset) {
  const Estimator estimator(model, beginning_of(dataset, std::min(samples, dataset.size())), lag,
                            with_offset);
  MemoryEstimate best = estimator.best_bias();
  using Kind = InitialMemory::Kind;
  for (const Kind kind : {Kind::virgin, Kind::from_lower, Kind::from_upper})
    if (const auto now = estimator.estimate_with({kind, 0.0}); now.rms <= best.rms) best = now;
  return best;
}

}  // namespace hystcan::identification
