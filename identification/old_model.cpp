#include "identification/old_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"
#include "identification/quasi_static.h"
#include "model/hysteresis.h"

namespace hystcan::identification {
namespace {

// Weight of all rows of the old model, as a share of the weight of the datasets.
constexpr double old_share = 1e-3;
// Number of first-order reversal curves from each branch of the major loop.
constexpr int reversal_curves = 6;
constexpr double least_rows = 400.0;  // minimum number of rows that represent the old model
// The old delay is left out if the error without delay is below this multiple of the error with this delay.
constexpr double worth_no_delay = 0.97;
// For each group of this number of dataset rows, the old model gets at least one row. The search uses only a
// part of all rows, with the same share for the datasets and for the old model. With fewer rows, the search
// would use too few rows of the old model.
constexpr double rows_of_datasets_to_one = 60.0;

/// Returns the inputs at which the path through the old model turns. The path begins at the upper threshold,
/// where the memory is empty; it follows the major loop and then the reversal curves.
std::vector<double> turns_of(const model::Interval& range) {
  std::vector<double> turns{range.hi, range.lo};
  const auto level = [&](int i) { return range.lo + range.span() * i / (reversal_curves + 1.0); };
  for (int i = 1; i <= reversal_curves; ++i) turns.insert(turns.end(), {level(i), range.lo});
  turns.push_back(range.hi);
  for (int i = reversal_curves; i >= 1; --i) turns.insert(turns.end(), {level(i), range.hi});
  return turns;
}

Dataset loops_of(const model::HysteresisParameters& old, const model::OutputCreep& creep,
                 const std::vector<Dataset>& datasets) {
  double rows = 0.0, longest_s = 0.0, travel = 0.0;
  for (const Dataset& dataset : datasets) {
    rows += static_cast<double>(dataset.size());
    longest_s = std::max(longest_s, dataset.time_s.back() - dataset.time_s.front());
  }
  const std::vector<double> turns = turns_of(old.input_range());
  for (std::size_t i = 1; i < turns.size(); ++i) travel += std::abs(turns[i] - turns[i - 1]);
  const double step = travel / std::max(least_rows, rows / rows_of_datasets_to_one);
  Dataset made{.input_unit = old.input_unit, .output_unit = old.output_unit};
  const model::Hysteresis model(old);
  auto state = model.at_upper_threshold();
  const auto add = [&](double input) {
    // The rows are far apart in time, so that a delay has no effect.
    made.time_s.push_back(longest_s * static_cast<double>(made.size()));
    made.input.push_back(input);
    made.output.push_back(model.advance(state, input).value);
  };
  add(turns.front());
  for (std::size_t i = 1; i < turns.size(); ++i) {
    const double from = turns[i - 1], length = turns[i] - from;
    const auto steps = static_cast<std::size_t>(std::ceil(std::abs(length) / step));
    for (std::size_t n = 1; n < steps; ++n)
      add(from + length * static_cast<double>(n) / static_cast<double>(steps));
    add(turns[i]);
  }
  made.output = with_creep(creep, made.time_s, std::move(made.output));
  made.weight.assign(made.size(), std::sqrt(old_share * rows / static_cast<double>(made.size())));
  return made;
}

CurveShape shape_of(const model::HysteresisParameters& old) {
  if (old.ascending.basis() != model::Basis::spline)
    return CurveShape::polynomial(
        std::clamp(static_cast<int>(old.ascending.coefficients().size()) - 1, 1, highest_order));
  CurveShape shape = CurveShape::spline(old.ascending.knots());
  shape.input_map = old.input_map;
  return shape;
}

/// Removes the last dataset, which represents the old model, from the result.
void leave_out_old_model(Identified& identified, const std::vector<Dataset>& datasets) {
  const std::size_t count = datasets.size();
  identified.memories.resize(count);
  identified.offsets.resize(count);
  identified.gains.resize(count);
  identified.drifts.resize(count);
  identified.datasets.resize(count);
  identified.folds.of.resize(count);
  identified.search.trial.memories.resize(count);
  if (!identified.search.trial.gains.empty()) identified.search.trial.gains.resize(count);
  for (Step& step : identified.search.steps)
    if (step.quantity == Quantity{Quantity::Kind::gain, count})
      step.quantity = {Quantity::Kind::gain_of_old_model};
  judge(identified, datasets);
  measure_span(identified, datasets);
}

}  // namespace

Identified identify_from(const OldModel& old, const std::vector<Dataset>& datasets, IdentifyOptions options) {
  const model::HysteresisParameters& parameters = old.parameters;
  if (parameters.output_map || options.output == ShapeOfOutput::butterfly)
    refuse("the old model is a butterfly, expected a model without an output map");
  const model::OutputCreep::Config searched{.per_decade = old.creep ? old.creep->per_decade : 0.0};
  if (old.creep && *old.creep != searched)
    refuse("the creep of the old model has time constants from ", old.creep->from_s, " to ", old.creep->to_s,
           " s, expected ", searched.from_s, " to ", searched.to_s, " s");
  options.output = parameters.symmetry == model::Symmetry::even ? ShapeOfOutput::even : ShapeOfOutput::none;
  if (!options.shape && options.curves == CurveChoice::automatic) options.shape = shape_of(parameters);
  options.never_held_out = 1;
  // The loops of the old model reach its thresholds, so that the observed inputs extend to these thresholds.
  options.observed_thresholds = true;
  std::vector<Dataset> all = datasets;
  if (!options.creep_per_decade) options.creep_per_decade = old.creep ? old.creep->per_decade : 0.0;
  const model::OutputCreep creep(creep_of(*options.creep_per_decade));
  all.push_back(loops_of(parameters, creep, datasets));
  const auto identified = [&] {
    Identified found = identify(all, options);
    leave_out_old_model(found, datasets);
    return found;
  };
  Identified found = identified();
  if (found.delay_s > 0.0 || options.delay_s || old.delay_s == 0.0 || found.stopped) return found;
  options.delay_s = old.delay_s;
  Identified delayed = identified();
  return found.overall.rms < worth_no_delay * delayed.overall.rms ? found : delayed;
}

}  // namespace hystcan::identification
