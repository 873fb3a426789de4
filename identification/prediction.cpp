#include "identification/prediction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "identification/creep_rows.h"
#include "identification/excerpt.h"
#include "identification/quasi_static.h"

namespace hystcan::identification {

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

double span_of(const std::vector<double>& values) {
  const auto [low, high] = std::ranges::minmax_element(values);
  return *high - *low;
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
  const Excerpt::Sequence sequence = Excerpt(dataset, {}, dataset.size(), 0.0).delayed_by(lag.delay_s);
  for (std::size_t i = 0; i < sequence.input.size(); ++i) {
    const double output = model.advance(state, sequence.input[i]).value;
    if (sequence.fold[i] != Regression::left_out) predicted.push_back(output);
  }
  return with_creep(creep, dataset.time_s, std::move(predicted), crept);
}

std::vector<double> predict(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                            const InitialMemory& memory) {
  const double first =
      model.symmetry() == model::Symmetry::even ? std::abs(dataset.input.front()) : dataset.input.front();
  model::HysteresisState state = state_of(model, memory, first);
  return predict(model, dataset, lag, state);
}

}  // namespace hystcan::identification
