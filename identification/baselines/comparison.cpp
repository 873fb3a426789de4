#include "identification/baselines/comparison.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "base/text.h"
#include "identification/baselines/baseline_models.h"
#include "identification/butterfly.h"
#include "identification/excerpt.h"
#include "identification/output_reference.h"
#include "identification/quasi_static.h"
#include "identification/regression.h"

namespace hystcan::identification {
namespace {

using Mask = std::vector<std::vector<bool>>;  // a flag for each sample, per dataset
using Kind = InitialMemory::Kind;

// Returns inputs that bring a baseline from its virgin state to this memory. Empty for the virgin memory.
std::vector<double> history_of(const InitialMemory& memory, model::Interval thresholds, double first) {
  std::vector<double> inputs;
  if (memory.kind == Kind::virgin) return inputs;
  inputs = {thresholds.hi, thresholds.lo};
  if (memory.kind == Kind::from_upper) std::swap(inputs.front(), inputs.back());
  for (const double v : prehistory(memory, thresholds, first)) inputs.push_back(v);
  return inputs;
}

// All datasets, joined into one sequence of samples for the baselines.
struct Joined {
  Samples samples;
  std::vector<std::size_t> place;  // for each sample of the datasets, its index in `samples`
};

Joined joined_sequence(const std::vector<Dataset>& datasets, const Identified& model, const Mask& fitted,
                       const std::function<bool()>& go_on) {
  const model::Interval thresholds = model.parameters.input_range();
  Joined joined{.samples = {{}, {}, {}, {}, thresholds, go_on}, .place = {}};
  const auto add_unweighted = [&joined](double v) {
    joined.samples.input.push_back(v);
    joined.samples.output.push_back(0.0);
    joined.samples.weight.push_back(0.0);
  };
  for (std::size_t r = 0; r < datasets.size(); ++r) {
    const double first = std::clamp(datasets[r].input.front(), thresholds.lo, thresholds.hi);
    InitialMemory memory = model.memories[r];
    if (r > 0 && memory.kind == Kind::virgin) memory = {Kind::nested, 0.0};
    const std::vector<double> history = history_of(memory, thresholds, first);
    if (r == 0) joined.samples.prehistory = history;
    if (r > 0) std::ranges::for_each(history, add_unweighted);
    const auto sequence = Excerpt(datasets[r], {}, datasets[r].size(), 0.0).delayed_by(model.delay_s);
    std::size_t n = 0;
    for (std::size_t i = 0; i < sequence.input.size(); ++i) {
      add_unweighted(sequence.input[i]);
      if (sequence.fold[i] == Regression::left_out) continue;
      joined.place.push_back(joined.samples.input.size() - 1);
      joined.samples.output.back() = sequence.output[i];
      joined.samples.weight.back() = fitted[r][n++] ? sequence.weight[i] * sequence.weight[i] : 0.0;
    }
  }
  return joined;
}

// Returns the errors over the samples that are marked in `judged`. `predicted` contains all datasets, one
// after the other.
ErrorNorms errors_of(const std::vector<double>& predicted, const std::vector<Dataset>& datasets,
                     const Mask& judged) {
  std::vector<double> model_output, measured;
  std::size_t n = 0;
  for (std::size_t r = 0; r < datasets.size(); ++r)
    for (std::size_t i = 0; i < datasets[r].size(); ++i, ++n) {
      if (!judged[r][i]) continue;
      model_output.push_back(predicted[n]);
      measured.push_back(datasets[r].output[i]);
    }
  return ErrorNorms::of(model_output, measured);
}

std::size_t count(const Mask& mask) {
  std::size_t counted = 0;
  for (const auto& samples : mask) counted += static_cast<std::size_t>(std::ranges::count(samples, true));
  return counted;
}

// Counts the marked cycles: a cycle begins at each marked sample whose previous sample is not marked. This is
// correct because only odd folds are marked. Consecutive cycles that can be held out get the folds 1, 2, 3,
// 4, 1 and so on, so that two marked cycles are never adjacent.
std::size_t cycles_in(const Mask& mask) {
  std::size_t cycles = 0;
  for (const auto& samples : mask)
    for (std::size_t i = 0; i < samples.size(); ++i) cycles += samples[i] && (i == 0 || !samples[i - 1]);
  return cycles;
}

Mask samples_where(const Folds& folds, const std::function<bool(int)>& is) {
  Mask mask;
  for (const auto& fold : folds.of) {
    mask.emplace_back();
    for (const int part : fold) mask.back().push_back(is(part));
  }
  return mask;
}

// Fits the baselines to the samples `fitted`. Computes the errors of the baselines and of the identified
// model over the samples `judged`. If the model is a butterfly, the baselines model its inner variable and
// use its output map.
class Contest {
 public:
  Contest(const std::vector<Dataset>& datasets, const Identified& model, const Mask& fitted, Mask judged,
          const std::function<bool()>& go_on)
      : datasets_(datasets),
        model_(model),
        judged_(std::move(judged)),
        joined_(joined_sequence(model.parameters.output_map ? linearised(datasets, model) : datasets, model,
                                fitted, go_on)) {}

  ErrorNorms of_model() const {
    std::vector<double> predicted;
    for (std::size_t r = 0; r < datasets_.size(); ++r) {
      const auto part = predict(model_, datasets_, r);
      predicted.insert(predicted.end(), part.begin(), part.end());
    }
    return errors_of(predicted, datasets_, judged_);
  }

  ComparisonRow of_baseline(const FitBaseline& fit) const {
    model::HysteresisParameters inner = model_.parameters;
    inner.output_map.reset();
    const BaselineModel baseline = fit(joined_.samples, inner);
    std::vector<double> predicted;
    for (const std::size_t place : joined_.place)
      predicted.push_back(model_.parameters.output(baseline.prediction[place]));
    return {baseline.name, baseline.parameters, errors_of(predicted, datasets_, judged_), std::nullopt};
  }

 private:
  const std::vector<Dataset>& datasets_;
  const Identified& model_;
  Mask judged_;
  Joined joined_;
};

// Returns the dataset without its own offset, gain and drift, because the baselines do not have them.
Dataset on_common_scale(Dataset dataset, double offset, double gain, double drift) {
  for (std::size_t i = 0; i < dataset.size(); ++i)
    dataset.output[i] = (dataset.output[i] - offset - drift * drift_course(dataset.time_s, i)) / gain;
  return dataset;
}

class Comparing {
 public:
  Comparing(const std::vector<Dataset>& datasets, const Identified& identified,
            const std::function<bool()>& go_on)
      : identified_(identified), go_on_(go_on) {
    const bool even = identified.parameters.symmetry == model::Symmetry::even;
    const std::vector<Dataset> still =
        identified.dynamics ? without_dynamics(datasets, identified) : datasets;
    for (std::size_t i = 0; i < still.size(); ++i)
      datasets_.push_back(on_common_scale(even ? folded(still[i]) : still[i], identified.offsets[i],
                                          identified.gains[i], identified.drifts[i]));
    const model::OutputCreep creep(identified.creep);
    for (Dataset& dataset : datasets_)
      dataset.output = without_creep(creep, dataset.time_s, std::move(dataset.output));
    identified_.dynamics.reset();
    identified_.creep.reset();
    for (auto* own : {&identified_.offsets, &identified_.drifts}) std::ranges::fill(*own, 0.0);
    std::ranges::fill(identified_.gains, 1.0);
    const std::vector<double> references = reference_outputs(datasets_, true);
    move_outputs(datasets_, references, -1.0);
    move_outputs(identified_, references, -1.0);
  }

  Comparison run() {
    const Mask seen = samples_where(identified_.folds, [](int part) { return part >= 0; });
    result_.output_span = identified_.output_span;
    result_.samples = count(seen);
    result_.cycles = identified_.folds.cycles;
    try {
      fit_all(seen);
      hold_out();
      result_.stopped = !go_on_();
    } catch (const Stopped&) {
      result_.stopped = true;
      result_.no_hold_out = "stopped before the comparison";
    }
    return result_;
  }

 private:
  void fit_all(const Mask& seen) {
    const Contest trial(datasets_, identified_, seen, seen, go_on_);
    result_.rows.push_back({"recursive memory-based, " + identified_.search.shape.text(),
                            identified_.parameter_count(), trial.of_model(), std::nullopt});
    for (const FitBaseline& fit : every_baseline()) {
      if (!go_on_()) return;
      try {
        result_.rows.push_back(trial.of_baseline(fit));
        baselines_.push_back(&fit);
      } catch (const std::invalid_argument& reason) {
        result_.refused.emplace_back(reason.what());
      }
    }
  }

  void hold_out() {
    const Mask unseen = held_out_samples(identified_.folds);
    result_.held_out_samples = count(unseen);
    result_.held_out_cycles = cycles_in(unseen);
    if (result_.held_out_samples == 0)
      result_.no_hold_out = text_of(
          "too few cycles (", result_.cycles,
          ") to leave some out of the fit; the cycles that reach the ends of the input range are always "
          "used");
    else if (const auto again = identify_without(unseen))
      judge_held_out(*again, unseen);
  }

  std::optional<Identified> identify_without(const Mask& unseen) {
    IdentifyOptions options;
    options.shape = identified_.search.shape;
    options.output = identified_.parameters.output_map                          ? ShapeOfOutput::butterfly
                     : identified_.parameters.symmetry == model::Symmetry::even ? ShapeOfOutput::even
                                                                                : ShapeOfOutput::none;
    options.observed_thresholds =
        identified_.search.trial.below == 0.0 && identified_.search.trial.above == 0.0;
    options.creep_per_decade = 0.0;
    options.go_on = go_on_;
    options.unseen = samples_where(identified_.folds, [](int part) { return part < 0; });
    for (std::size_t r = 0; r < unseen.size(); ++r)
      for (std::size_t i = 0; i < unseen[r].size(); ++i)
        options.unseen[r][i] = options.unseen[r][i] || unseen[r][i];
    try {
      if (!go_on_()) throw std::invalid_argument("stopped before the comparison");
      Identified again = identify(datasets_, options);
      if (again.stopped) throw std::invalid_argument("stopped before the comparison");
      return again;
    } catch (const std::invalid_argument& reason) {
      result_.no_hold_out = reason.what();
      return std::nullopt;
    }
  }

  void judge_held_out(const Identified& again, const Mask& unseen) {
    const Mask seen = samples_where(identified_.folds, [](int part) { return part >= 0 && part % 2 == 0; });
    const Contest trial(datasets_, again, seen, unseen, go_on_);
    result_.rows.front().held_out = trial.of_model();
    for (std::size_t i = 0; i < baselines_.size() && go_on_(); ++i) {
      try {
        result_.rows[i + 1].held_out = trial.of_baseline(*baselines_[i]).fit;
      } catch (const std::invalid_argument& reason) {
        result_.refused.push_back(result_.rows[i + 1].name + ", held out: " + reason.what());
      }
    }
  }

  Identified identified_;  // the identified model, for datasets with a common zero and gain
  const std::function<bool()>& go_on_;
  std::vector<Dataset> datasets_;
  std::vector<const FitBaseline*> baselines_;  // the baseline of each row except the first
  Comparison result_;
};

}  // namespace

std::vector<std::vector<bool>> held_out_samples(const Folds& folds) {
  return samples_where(folds, [](int part) { return part > 0 && part % 2 == 1; });
}

Comparison compare(const std::vector<Dataset>& datasets, const Identified& identified,
                   const std::function<bool()>& go_on) {
  return Comparing(datasets, identified, go_on).run();
}

}  // namespace hystcan::identification
