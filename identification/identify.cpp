#include "identification/identify.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <numeric>

#include "base/text.h"
#include "identification/butterfly.h"
#include "identification/excerpt.h"
#include "identification/knot_places.h"

namespace hystcan::identification {
namespace {

constexpr double unexplained = 0.5;       // of the output's standard deviation: the model is refused
constexpr double worth_a_map = 0.9;       // of the held-out error without it
constexpr int most_pieces = 22;           // of a spline
constexpr std::size_t finer_samples = 5;  // times those of the search, for its last steps
constexpr double shows_creep_s = 0.005;   // between samples: half of the shortest lag

model::Interval span_over(const std::vector<Dataset>& datasets, const std::vector<double> Dataset::*column) {
  model::Interval range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Dataset& dataset : datasets) {
    const auto [low, high] = std::ranges::minmax_element(dataset.*column);
    range.lo = std::min(range.lo, *low);
    range.hi = std::max(range.hi, *high);
  }
  return range;
}

std::size_t samples_of(const std::vector<Dataset>& datasets) {
  std::size_t samples = 0;
  for (const Dataset& dataset : datasets) samples += dataset.size();
  return samples;
}

double deviation(const std::vector<Dataset>& datasets) {
  double sum = 0.0, square = 0.0;
  for (const Dataset& dataset : datasets)
    for (const double x : dataset.output) sum += x;
  const auto count = static_cast<double>(samples_of(datasets));
  for (const Dataset& dataset : datasets)
    for (const double x : dataset.output) square += (x - sum / count) * (x - sum / count);
  return std::sqrt(square / count);
}

// The dataset without the unseen samples.
Dataset without(const Dataset& dataset, const std::vector<bool>& unseen) {
  if (unseen.size() != dataset.size())
    refuse("unseen flags of ", unseen.size(), " samples, expected ", dataset.size());
  Dataset seen{dataset.input_unit, dataset.output_unit, {}, {}, {}};
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    if (unseen[i]) continue;
    seen.time_s.push_back(dataset.time_s[i]);
    seen.input.push_back(dataset.input[i]);
    seen.output.push_back(dataset.output[i]);
  }
  return seen;
}

// An even model is folded at zero, even if the input never reaches zero.
model::Interval thresholds_observed(const std::vector<Dataset>& datasets, model::Symmetry symmetry) {
  model::Interval range = span_over(datasets, &Dataset::input);
  if (symmetry == model::Symmetry::even) range.lo = 0.0;
  return range;
}

// The problem with all samples in one fold, without unseen samples.
Problem unfolded(const Problem& excerpt, const std::vector<Dataset>& datasets, const Folds& folds) {
  Problem problem = excerpt;
  problem.folds = 1;
  problem.excerpts.clear();
  for (std::size_t r = 0; r < datasets.size(); ++r) {
    std::vector<int> fold = folds.of[r];
    for (int& part : fold) part = std::min(part, 0);
    problem.excerpts.emplace_back(datasets[r], std::move(fold), datasets[r].size(), 0.0);
  }
  return problem;
}

// With all samples the best curves can be very slightly invalid: k is lowered until they are valid.
Fitted fit_to_all(SeparableFit& fit, Trial& trial) {
  Fitted fitted = fit.fit(trial);
  for (int tries = 0; !fitted.valid && tries < 90; ++tries) {
    trial.k_span_ascending *= 0.95;
    trial.k_span_descending *= 0.95;
    fitted = fit.fit(trial);
  }
  return fitted;
}

// A zero of its own can be told from the curves only where others have the same inputs: each dataset must be tied to
// the first, directly or through others.
void check_common_inputs(const std::vector<Dataset>& datasets) {
  std::vector<model::Interval> ranges;
  ranges.reserve(datasets.size());
  for (const Dataset& dataset : datasets) ranges.push_back(span_over({dataset}, &Dataset::input));
  std::vector<std::size_t> apart(datasets.size() - 1);
  std::iota(apart.begin(), apart.end(), 1);
  model::Interval tied = ranges.front();
  for (bool grows = true; grows;)
    grows = std::erase_if(apart, [&](std::size_t i) {
              const bool common = std::min(ranges[i].hi, tied.hi) > std::max(ranges[i].lo, tied.lo);
              if (common) tied = {std::min(ranges[i].lo, tied.lo), std::max(ranges[i].hi, tied.hi)};
              return common;
            }) > 0;
  if (apart.empty()) return;
  const std::size_t i = apart.front();
  refuse("dataset ", i + 1, " has inputs from ", ranges[i].lo, " to ", ranges[i].hi, ", the others from ",
         tied.lo, " to ", tied.hi,
         ": without common inputs its zero is unknown; expected some, or a common zero");
}

class Identification {
 public:
  Identification(const std::vector<Dataset>& datasets, const IdentifyOptions& options) : options_(options) {
    if (!options_.go_on) options_.go_on = [] { return true; };
    if (datasets.empty()) refuse("no dataset, expected at least one");
    std::ranges::for_each(datasets, check_limits);
    if (!options.unseen.empty() && options.unseen.size() != datasets.size())
      refuse("unseen flags of ", options.unseen.size(), " datasets, expected ", datasets.size());
    for (std::size_t r = 0; r < datasets.size(); ++r)
      seen_.push_back(options.unseen.empty() ? datasets[r] : without(datasets[r], options.unseen[r]));
    if (options_.delay_s && !(*options_.delay_s >= 0.0))
      refuse("delay ", *options_.delay_s, " s, expected 0 or more");
    symmetry_ = options.output == ShapeOfOutput::automatic ? symmetry_of(seen_.front())
                : options.output == ShapeOfOutput::even    ? model::Symmetry::even
                                                           : model::Symmetry::none;
    for (const Dataset& dataset : seen_) check_identifiable(dataset, symmetry_);
    for (const Dataset& dataset : datasets)
      datasets_.push_back(symmetry_ == model::Symmetry::even ? folded(dataset) : dataset);
    if (!options_.common_zero) check_common_inputs(datasets_);
    for (const Dataset& dataset : datasets_) check_delay(dataset);
  }

  Identified run() {
    set_up();
    SearchOptions options = search_options();
    const Problem finer = excerpts_of(finer_samples * options_.search_samples);
    options.finer = &finer;
    CreepChoice chosen = choose_creep(problem_, first_inputs(), options);
    result_.search = std::move(chosen.found);
    result_.other = std::move(chosen.other);
    if (result_.search.rms > unexplained * deviation(seen_))
      refuse("the best model misses the output by ",
             std::round(100.0 * result_.search.rms / deviation(seen_)),
             " % of its standard deviation: the output does not follow the input");
    fit_all();
    result_.pace_ascending = pace_range(&Trial::k_span_ascending);
    result_.pace_descending = pace_range(&Trial::k_span_descending);
    if (options.sample_time_s > 0.0 && !options.delay_s && options_.go_on())
      result_.delay_range = delay_range(problem_, result_.search, datasets_, options_.go_on);
    if (result_.creep && !options.creep_per_decade && options_.go_on())
      result_.creep_range = creep_range(problem_, result_.search, options_.go_on);
    if (problem_.whole_excerpts && options_.go_on())
      result_.left_out = SeparableFit(problem_, result_.search.shape, SeparableFit::Scan::coarse)
                             .left_out(result_.search.trial);
    result_.stopped = !options_.go_on();
    return result_;
  }

 private:
  void check_delay(const Dataset& dataset) const {
    const double lasts_s = dataset.time_s.back() - dataset.time_s.front();
    if (options_.delay_s && !(*options_.delay_s < lasts_s))
      refuse("delay ", *options_.delay_s, " s, expected less than a dataset lasts, ", lasts_s, " s");
  }

  void set_up() {
    problem_.symmetry = symmetry_;
    problem_.observed = thresholds_observed(datasets_, symmetry_);
    problem_.output_span = span_over(seen_, &Dataset::output).span();
    result_.folds = folds_that_count(assign_folds(datasets_, problem_.observed));
    problem_.whole_excerpts = datasets_.size() - options_.never_held_out > 1;
    held_out_ = problem_.whole_excerpts ? folds_that_count(records_as_folds(datasets_, problem_.observed))
                                        : result_.folds;
    problem_.folds = held_out_.count;
    problem_.regressors = static_cast<Eigen::Index>(datasets_.front().regressors.size());
    for (std::size_t i = 0; i < datasets_.size(); ++i) {
      result_.datasets.push_back(characterise(datasets_[i], problem_.observed));
      problem_.nuisances.push_back({i > 0 && !options_.common_zero, options_.drift});
    }
    problem_ = excerpts_of(options_.search_samples);
    result_.observed = problem_.observed;
    result_.output_span = problem_.output_span;
  }

  Folds folds_that_count(Folds folds) const {
    for (std::size_t r = datasets_.size() - options_.never_held_out; r < datasets_.size(); ++r)
      std::ranges::fill(folds.of[r], 0);
    for (std::size_t r = 0; r < options_.unseen.size(); ++r)
      for (std::size_t i = 0; i < datasets_[r].size(); ++i)
        if (options_.unseen[r][i]) folds.of[r][i] = Regression::left_out;
    return folds;
  }

  Problem excerpts_of(std::size_t search_samples) const {
    Problem problem = problem_;
    problem.excerpts.clear();
    const std::size_t samples = samples_of(datasets_);
    for (std::size_t i = 0; i < datasets_.size(); ++i) {
      const Dataset& dataset = datasets_[i];
      const std::size_t share = std::max<std::size_t>(50, search_samples * dataset.size() / samples);
      problem.excerpts.emplace_back(dataset, held_out_.of[i], share,
                                    least_swing(dataset, problem.observed.span()));
    }
    return problem;
  }

  std::vector<double> first_inputs() const {
    std::vector<double> first;
    for (const Dataset& dataset : datasets_) first.push_back(dataset.input.front());
    return first;
  }

  SearchOptions search_options() const {
    const auto samples = static_cast<int>(std::min<std::size_t>(samples_of(datasets_), 10000));
    SearchOptions search;
    search.highest_order = std::clamp((samples / 3 - 3) / 2, 1, highest_order);
    if (const auto& shape = options_.shape; shape && !shape->is_spline()) {
      if (shape->order < 1) refuse("order ", shape->order, ", expected at least 1");
      if (shape->order > search.highest_order)
        refuse("order ", shape->order, " from ", samples, " samples, expected at most ",
               search.highest_order);
    }
    search.curves = options_.curves;
    search.shape = options_.shape;
    search.delay_s = options_.delay_s;
    search.creep_per_decade = options_.creep_per_decade;
    if (std::ranges::all_of(result_.datasets,
                            [](const Characterisation& is) { return is.sample_time_s > shows_creep_s; }))
      search.creep_per_decade = search.creep_per_decade.value_or(0.0);
    if (options_.longest_delay_s) search.longest_delay_s = *options_.longest_delay_s;
    search.knots = [places = KnotPlaces(datasets_, problem_.observed)](int pieces) {
      return places.knots(pieces);
    };
    search.most_pieces = std::min(most_pieces, (samples / 3 - 3) / 2 - 2);
    search.own_gains = datasets_.size() > 1 && !options_.common_gain;
    search.observed_thresholds = options_.observed_thresholds;
    search.go_on = options_.go_on;
    // A delay can be distinguished from the width of a loop only if a half cycle has enough samples.
    for (const Characterisation& is : result_.datasets)
      if (static_cast<double>(is.samples) > 100.0 * static_cast<double>(is.cycles))
        search.sample_time_s =
            search.sample_time_s > 0.0 ? std::min(search.sample_time_s, is.sample_time_s) : is.sample_time_s;
    return search;
  }

  void fit_all() {
    const Problem all = options_.go_on() ? unfolded(problem_, datasets_, result_.folds) : problem_;
    SeparableFit fit(all, result_.search.shape, SeparableFit::Scan::fine);
    Trial& trial = result_.search.trial;
    const Fitted fitted = fit_to_all(fit, trial);
    result_.parameters = fitted.parameters;
    result_.parameters.input_unit = datasets_.front().input_unit;
    result_.parameters.output_unit = datasets_.front().output_unit;
    if (!fitted.valid)
      refuse("no model with an inverse fits: some branch decreases for every k; is this a hysteresis loop?");
    result_.delay_s = trial.delay_s;
    result_.creep = creep_of(trial.creep_per_decade);
    result_.memories = trial.memories;
    result_.offsets = fitted.offsets;
    result_.drifts = fitted.drifts;
    for (std::size_t i = 0; i < datasets_.size(); ++i) result_.gains.push_back(trial.gain(i));
    std::vector<Dataset> on_one_zero = seen_;
    for (std::size_t i = 0; i < on_one_zero.size(); ++i)
      for (double& output : on_one_zero[i].output) output = (output - result_.offsets[i]) / result_.gains[i];
    result_.output_span = span_over(on_one_zero, &Dataset::output).span();
    result_.held_out_rms = result_.search.held_out;
    judge(result_, datasets_);
    if (!std::isfinite(result_.overall.rms))
      refuse("the model that fits best has no finite error; expected a dataset that a model can describe");
  }

  // Searches outwards from the best k, in steps that grow by half each time.
  PaceRange pace_range(double Trial::*k) const {
    SeparableFit fit(problem_, result_.search.shape, SeparableFit::Scan::coarse);
    Trial trial = result_.search.trial;
    const double best = trial.*k, largest_rms = 1.05 * fit.fit(trial).rms;
    const auto is_as_good = [&](double value) {
      trial.*k = value;
      const Fitted fitted = fit.fit(trial);
      return fitted.valid && fitted.rms <= largest_rms;
    };
    const double scale = std::max(std::abs(best), 0.03);
    const auto farthest = [&](double way) {
      double last = best, step = 0.05 * scale;
      for (int i = 0; i < 19 && options_.go_on() && is_as_good(best + way * step); ++i, step *= 1.5)
        last = best + way * step;
      return last;
    };
    const double lo = farthest(-1.0), hi = farthest(1.0);
    const double span = result_.parameters.input_range().span();
    return {lo / span, hi / span, lo * hi > 0.0 && std::max(lo / hi, hi / lo) < 10.0};
  }

  IdentifyOptions options_;
  model::Symmetry symmetry_ = model::Symmetry::none;
  std::vector<Dataset> seen_;      // without unseen samples
  std::vector<Dataset> datasets_;  // folded
  Problem problem_;
  Folds held_out_;  // in the search
  Identified result_;
};

// The butterfly has to pay for its map.
Identified better_of(const Identified& plain, Identified butterfly) {
  const bool held_out = plain.held_out_rms && butterfly.held_out_rms;
  const double before = held_out ? *plain.held_out_rms : plain.overall.rms;
  const double after = held_out ? *butterfly.held_out_rms : butterfly.overall.rms;
  if (!(after < worth_a_map * before)) return plain;
  butterfly.search.steps.insert(
      butterfly.search.steps.begin(),
      {"output map", plain.overall.rms, butterfly.overall.rms, plain.held_out_rms, butterfly.held_out_rms});
  return butterfly;
}

}  // namespace

std::size_t Identified::parameter_count() const {
  const Trial& trial = search.trial;
  const auto curves = 2 * static_cast<std::size_t>(search.shape.coefficients()) - 1;
  return curves + (search.one_k ? 1 : 2) + (trial.below > 0.0 ? 1 : 0) + (trial.above > 0.0 ? 1 : 0) +
         (delay_s > 0.0 ? 1 : 0) + (creep ? 1 : 0) + (dynamics ? 3 : 0) +
         (parameters.output_map ? parameters.output_map->coefficients().size() : 0);
}

std::vector<double> predict(const Identified& identified, const std::vector<Dataset>& datasets,
                            std::size_t i) {
  const Dataset dataset =
      identified.parameters.symmetry == model::Symmetry::even ? folded(datasets[i]) : datasets[i];
  std::vector<double> predicted =
      predict(model::Hysteresis(identified.parameters), dataset, identified.lag(), identified.memories[i]);
  for (std::size_t j = 0; j < predicted.size(); ++j)
    predicted[j] = identified.gains[i] * predicted[j] + identified.zero_at(i, dataset.time_s, j);
  return predicted;
}

void judge(Identified& identified, const std::vector<Dataset>& datasets) {
  identified.misses.clear();
  identified.overall = {};
  double square = 0.0;
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    const ErrorNorms misses = ErrorNorms::of(predict(identified, datasets, i), datasets[i].output);
    identified.misses.push_back(misses);
    identified.overall.max = std::max(identified.overall.max, misses.max);
    square += misses.rms * misses.rms * static_cast<double>(datasets[i].size());
  }
  identified.overall.rms = std::sqrt(square / static_cast<double>(samples_of(datasets)));
}

Identified identify(const std::vector<Dataset>& datasets, const IdentifyOptions& options) {
  const IdentifyDatasets curves = [](const std::vector<Dataset>& given, const IdentifyOptions& asked) {
    return Identification(given, asked).run();
  };
  if (options.output == ShapeOfOutput::butterfly) return identify_butterfly(datasets, options, curves);
  const bool may_be = options.output == ShapeOfOutput::automatic && !datasets.empty() &&
                      std::ranges::all_of(datasets, passes_valley);
  if (!may_be) return curves(datasets, options);
  std::exception_ptr reason;  // of the first that finds nothing
  const auto or_nothing = [&reason](const auto& find) -> std::optional<Identified> {
    try {
      return find();
    } catch (const std::invalid_argument&) {
      if (!reason) reason = std::current_exception();
      return std::nullopt;
    }
  };
  const auto plain = or_nothing([&] { return curves(datasets, options); });
  if (plain && plain->stopped) return *plain;
  const auto butterfly = or_nothing([&] { return identify_butterfly(datasets, options, curves); });
  if (plain && butterfly) return better_of(*plain, *butterfly);
  if (!plain && !butterfly) std::rethrow_exception(reason);
  return plain ? *plain : *butterfly;
}

}  // namespace hystcan::identification
