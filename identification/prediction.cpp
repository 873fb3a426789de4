#include "identification/prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "identification/excerpt.h"
#include "identification/quasi_static.h"
#include "identification/regression.h"

namespace hystcan::identification {
namespace {

constexpr int loops = 16;

constexpr double bias_step = 0.5;  // step of the search grid for the bias
constexpr int widest_bias = 10;    // largest bias of the search grid, in steps

Dataset beginning_of(const Dataset& dataset, std::size_t samples) {
  Dataset beginning = dataset;
  for (auto* column : {&beginning.time_s, &beginning.input, &beginning.output}) column->resize(samples);
  return beginning;
}

}  // namespace

model::Origin InitialMemory::origin() const {
  switch (kind) {
    case Kind::virgin:
      return model::Origin::virgin;
    case Kind::from_upper:
      return model::Origin::upper_threshold;
    case Kind::from_lower:
    case Kind::nested:
      break;
  }
  return model::Origin::lower_threshold;
}

bool shows_ascending_curve(const std::vector<InitialMemory>& memories) {
  return std::ranges::find(memories, InitialMemory::Kind::virgin, &InitialMemory::kind) != memories.end();
}

std::vector<double> prehistory(const InitialMemory& memory, model::Interval thresholds, double first) {
  std::vector<double> inputs;
  if (memory.kind != InitialMemory::Kind::nested) return inputs;
  const double up = std::exp(memory.bias), down = std::exp(-memory.bias);
  for (int j = 1; j <= loops; ++j) {
    const double left = 1.0 - j / (loops + 1.0);
    inputs.push_back(first + (thresholds.hi - first) * std::pow(left, up));
    inputs.push_back(first - (first - thresholds.lo) * std::pow(left, down));
  }
  return inputs;
}

model::HysteresisState state_of(const model::Hysteresis& model, const InitialMemory& memory, double first) {
  const model::Interval& range = model.input_range();
  const double travelled = model.symmetry() == model::Symmetry::even ? std::abs(first) : first;
  const double start = std::clamp(travelled, range.lo, range.hi);
  if (memory.kind == InitialMemory::Kind::virgin) return model.virgin(start);
  model::HysteresisState state = memory.kind == InitialMemory::Kind::from_upper ? model.at_upper_threshold()
                                                                                : model.at_lower_threshold();
  for (const double input : prehistory(memory, range, start)) model.advance(state, input);
  model.advance(state, start);
  return state;
}

ErrorNorms ErrorNorms::of(const std::vector<double>& predicted, const std::vector<double>& measured,
                          std::size_t begin) {
  ErrorNorms errors;
  for (std::size_t i = begin; i < measured.size(); ++i) {
    const double error = predicted[i] - measured[i];
    errors.rms += error * error;
    errors.max = std::max(errors.max, std::abs(error));
  }
  if (measured.size() > begin)
    errors.rms = std::sqrt(errors.rms / static_cast<double>(measured.size() - begin));
  return errors;
}

std::vector<double> predict(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                            model::HysteresisState& state,
                            const std::optional<model::HeldCreep::State>& crept) {
  const model::OutputCreep creep(lag.creep);
  std::vector<double> predicted;
  predicted.reserve(dataset.size());
  if (lag.dynamics || lag.delay_s == 0.0) {
    for (const double v : dataset.input) predicted.push_back(model.advance(state, v).value);
    predicted = with_creep(creep, dataset.time_s, std::move(predicted), crept);
    return lag.dynamics ? respond(*lag.dynamics, dataset.time_s, predicted) : predicted;
  }
  const Dataset sequence = Excerpt(dataset, {}, dataset.size(), 0.0).delayed_by(lag.delay_s);
  for (std::size_t i = 0; i < sequence.input.size(); ++i) {
    const double output = model.advance(state, sequence.input[i]).value;
    if (sequence.fold[i] != Regression::left_out) predicted.push_back(output);
  }
  return with_creep(creep, dataset.time_s, std::move(predicted), crept);
}

std::vector<double> predict(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                            const InitialMemory& memory) {
  model::HysteresisState state = state_of(model, memory, dataset.input.front());
  return predict(model, dataset, lag, state);
}

std::vector<RateError> errors_by_rate(const Dataset& dataset, const std::vector<double>& predicted) {
  const double range = span_of(dataset.input);
  struct Class {
    double travel = 0.0, lasts_s = 0.0, square = 0.0;
    std::size_t samples = 0;
  };
  std::map<int, Class> classes;
  for (const HalfCycle& half : half_cycles(dataset, 0.02 * range)) {
    const double travel = std::abs(half.to - half.from);
    const double lasts_s = dataset.time_s[half.end - 1] - dataset.time_s[half.begin];
    if (!(travel > 0.05 * range) || !(lasts_s > 0.0)) continue;
    Class& of = classes[static_cast<int>(std::floor(std::log2(travel / lasts_s)))];
    of.travel += travel;
    of.lasts_s += lasts_s;
    of.samples += half.end - half.begin;
    for (std::size_t i = half.begin; i < half.end; ++i)
      of.square += (predicted[i] - dataset.output[i]) * (predicted[i] - dataset.output[i]);
  }
  std::vector<RateError> errors;
  errors.reserve(classes.size());
  for (const auto& [octave, of] : classes)
    errors.push_back(
        {of.travel / of.lasts_s, std::sqrt(of.square / static_cast<double>(of.samples)), of.samples});
  return errors;
}

MemoryEstimate estimate_memory(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                               std::size_t samples, bool with_offset) {
  using Kind = InitialMemory::Kind;
  const Dataset beginning = beginning_of(dataset, std::min(samples, dataset.size()));
  const auto estimate_with = [&](const InitialMemory& memory) {
    const std::vector<double> predicted = predict(model, beginning, lag, memory);
    MemoryEstimate estimate{memory, 0.0, 0.0};
    const auto count = static_cast<double>(predicted.size());
    if (with_offset)
      for (std::size_t i = 0; i < predicted.size(); ++i)
        estimate.offset += (beginning.output[i] - predicted[i]) / count;
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      const double error = beginning.output[i] - predicted[i] - estimate.offset;
      estimate.rms += error * error / count;
    }
    estimate.rms = std::sqrt(estimate.rms);
    return estimate;
  };
  // Finds the best bias of a nested initial memory on a grid, then refines it by a golden section search.
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
  for (const Kind kind : {Kind::virgin, Kind::from_lower, Kind::from_upper})
    if (const auto now = estimate_with({kind, 0.0}); now.rms <= best.rms) best = now;
  return best;
}

}  // namespace hystcan::identification
