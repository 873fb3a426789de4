#include "identification/identify.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <limits>
#include <numeric>

#include "base/text.h"
#include "identification/ascending_choice.h"
#include "identification/butterfly.h"
#include "identification/output_reference.h"
#include "identification/regression.h"
#include "identification/shape_choice.h"

namespace hystcan::identification {
namespace {

// A model is refused if its error exceeds this share of the output's standard deviation.
constexpr double unexplained = 0.5;
// An output map is used only if it lowers the held-out error to this share of the error without it.
constexpr double worth_a_map = 0.9;
constexpr int most_pieces = 22;           // maximum number of pieces of a spline
constexpr std::size_t finer_samples = 5;  // the last steps of a search use so many times more samples
constexpr double worth_creep = 0.97;      // maximum score of a model with creep, relative to one without
constexpr double shows_creep_s = 0.005;   // longer time steps do not show creep (half of the shortest lag)
// If no sample is on the ascending reference curve, this curve is replaced (ascending_choice.h). The new
// curve may change the output by at most this share of the RMS error.
constexpr double unnoticed = 0.1;
constexpr double rounding = 1e-9;  // tolerance for rounding errors, as a share of the output range

model::Interval span_over(const std::vector<Dataset>& datasets, const std::vector<double> Dataset::*column) {
  model::Interval range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Dataset& dataset : datasets) {
    const model::Interval own = range_of(dataset.*column);
    range = {std::min(range.lo, own.lo), std::max(range.hi, own.hi)};
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

// Returns the range of the inputs. With even symmetry, the range always begins at 0.
model::Interval thresholds_observed(const std::vector<Dataset>& datasets, model::Symmetry symmetry) {
  model::Interval range = span_over(datasets, &Dataset::input);
  if (symmetry == model::Symmetry::even) range.lo = 0.0;
  return range;
}

// Returns the problem with all samples in one fold. The result refers to `folds`, which this function
// changes.
Problem unfolded(const Problem& excerpt, const std::vector<Dataset>& datasets, Folds& folds) {
  Problem problem = excerpt;
  problem.folds = 1;
  problem.excerpts.clear();
  for (std::size_t r = 0; r < datasets.size(); ++r) {
    for (int& part : folds.of[r]) part = std::min(part, 0);
    problem.excerpts.emplace_back(datasets[r], folds.of[r], datasets[r].size(), 0.0);
  }
  return problem;
}

// Returns the fit to all samples. While a branch decreases, lowers both convergence rates and fits again.
Fitted fit_to_all(SeparableFit& fit, Trial& trial) {
  Fitted fitted = fit.fit(trial);
  for (int tries = 0; !fitted.valid && tries < 90; ++tries) {
    trial.k_span_ascending *= 0.95;
    trial.k_span_descending *= 0.95;
    fitted = fit.fit(trial);
  }
  if (fitted.valid && !shows_ascending_curve(trial.memories))
    fitted.parameters = with_ascending_from_lower(
        fitted.parameters, unnoticed * fitted.rms + rounding * fitted.parameters.output_range().span());
  return fitted;
}

// Throws std::invalid_argument if a dataset has no inputs in common with the first, directly or through other
// datasets. Then its offset cannot be distinguished from a change of the curves.
void check_common_inputs(const std::vector<Dataset>& datasets) {
  std::vector<model::Interval> ranges;
  ranges.reserve(datasets.size());
  for (const Dataset& dataset : datasets) ranges.push_back(range_of(dataset.input));
  std::vector<std::size_t> unconnected(datasets.size() - 1);
  std::iota(unconnected.begin(), unconnected.end(), 1);
  model::Interval tied = ranges.front();
  for (bool grows = true; grows;)
    grows = std::erase_if(unconnected, [&](std::size_t i) {
              const bool common = std::min(ranges[i].hi, tied.hi) > std::max(ranges[i].lo, tied.lo);
              if (common) tied = {std::min(ranges[i].lo, tied.lo), std::max(ranges[i].hi, tied.hi)};
              return common;
            }) > 0;
  if (unconnected.empty()) return;
  const std::size_t i = unconnected.front();
  refuse(
      "dataset ", i + 1, " has inputs from ", ranges[i].lo, " to ", ranges[i].hi, ", the others from ",
      tied.lo, " to ", tied.hi,
      ": without common inputs the output offset between the datasets is unknown, expected common inputs, or "
      "the same output zero for all datasets (option --common-zero)");
}

class Identification {
 public:
  Identification(const std::vector<Dataset>& given, const IdentifyOptions& options)
      : options_(options), given_(given) {
    if (!options_.go_on) options_.go_on = [] { return true; };
    if (given.empty()) refuse("no dataset, expected at least one");
    std::ranges::for_each(given, check_limits);
    if (!options.unseen.empty() && options.unseen.size() != given.size())
      refuse("unseen flags of ", options.unseen.size(), " datasets, expected ", given.size());
    for (std::size_t r = 0; r < options.unseen.size(); ++r)
      without_unseen_.push_back(without(given[r], options.unseen[r]));
    if (options_.delay_s && !(*options_.delay_s >= 0.0))
      refuse("delay ", *options_.delay_s, " s, expected 0 or more");
    symmetry_ = options.output == ShapeOfOutput::automatic ? symmetry_of(seen().front())
                : options.output == ShapeOfOutput::even    ? model::Symmetry::even
                                                           : model::Symmetry::none;
    for (const Dataset& dataset : seen()) check_identifiable(dataset, symmetry_);
    if (symmetry_ == model::Symmetry::even)
      std::ranges::transform(given, std::back_inserter(folded_), folded);
    if (!options_.common_zero) check_common_inputs(datasets());
    for (const Dataset& dataset : given) check_delay(dataset);
  }

  Identified run() {
    set_up();
    choose_creep(excerpts_of(finer_samples * options_.search_samples));
    if (result_.search.rms > unexplained * deviation(seen()))
      refuse("the error of the best model is ", std::round(100.0 * result_.search.rms / deviation(seen())),
             " % of the standard deviation of the output: the output does not follow the input");
    fit_all();
    result_.pace_ascending = pace_range(problem_, result_.search, &Trial::k_span_ascending, options_.go_on);
    result_.pace_descending = pace_range(problem_, result_.search, &Trial::k_span_descending, options_.go_on);
    if (problem_.sample_time_s > 0.0 && !options_.delay_s && options_.go_on())
      result_.delay_range = delay_range(problem_, result_.search, datasets(), options_.go_on);
    if (result_.creep && !options_.creep_per_decade && options_.go_on())
      result_.creep_range = creep_range(problem_, result_.search, options_.go_on);
    if (result_.creep && given_.size() > 1 && !options_.common_gain && options_.go_on())
      result_.gains_instead = gains_instead_of_creep(problem_, result_.search, options_.go_on);
    if (problem_.whole_excerpts && options_.go_on())
      result_.left_out = SeparableFit(problem_, result_.search.shape, SeparableFit::coarse_scan)
                             .left_out(result_.search.trial);
    result_.stopped = !options_.go_on();
    return result_;
  }

 private:
  const std::vector<Dataset>& seen() const { return options_.unseen.empty() ? given_ : without_unseen_; }
  const std::vector<Dataset>& datasets() const { return folded_.empty() ? given_ : folded_; }

  void check_delay(const Dataset& dataset) const {
    const double lasts_s = dataset.time_s.back() - dataset.time_s.front();
    if (options_.delay_s && !(*options_.delay_s < lasts_s))
      refuse("delay ", *options_.delay_s, " s, expected less than the duration of a dataset, ", lasts_s,
             " s");
  }

  void set_up() {
    problem_.symmetry = symmetry_;
    problem_.observed = thresholds_observed(datasets(), symmetry_);
    problem_.output_span = span_over(seen(), &Dataset::output).span();
    result_.folds = folds_that_count(assign_folds(datasets(), problem_.observed));
    problem_.whole_excerpts = datasets().size() - options_.never_held_out > 1;
    held_out_ = problem_.whole_excerpts ? folds_that_count(records_as_folds(datasets(), problem_.observed))
                                        : result_.folds;
    problem_.folds = held_out_.count;
    problem_.regressors = static_cast<Eigen::Index>(datasets().front().regressors.size());
    for (std::size_t i = 0; i < datasets().size(); ++i) {
      result_.datasets.push_back(characterise(datasets()[i], problem_.observed));
      problem_.nuisances.push_back({i > 0 && !options_.common_zero, options_.drift});
    }
    problem_ = excerpts_of(options_.search_samples);
    limit_search();
    result_.observed = problem_.observed;
    result_.output_span = problem_.output_span;
  }

  Folds folds_that_count(Folds folds) const {
    for (std::size_t r = datasets().size() - options_.never_held_out; r < datasets().size(); ++r)
      std::ranges::fill(folds.of[r], 0);
    for (std::size_t r = 0; r < options_.unseen.size(); ++r)
      for (std::size_t i = 0; i < datasets()[r].size(); ++i)
        if (options_.unseen[r][i]) folds.of[r][i] = Regression::left_out;
    return folds;
  }

  Problem excerpts_of(std::size_t search_samples) const {
    Problem problem = problem_;
    problem.excerpts.clear();
    const std::size_t samples = samples_of(datasets());
    for (std::size_t i = 0; i < datasets().size(); ++i) {
      const Dataset& dataset = datasets()[i];
      const std::size_t share = std::max<std::size_t>(50, search_samples * dataset.size() / samples);
      problem.excerpts.emplace_back(dataset, held_out_.of[i], share,
                                    least_swing(dataset, problem.observed.span()));
    }
    return problem;
  }

  void limit_search() {
    const auto samples = static_cast<int>(std::min<std::size_t>(samples_of(datasets()), 10000));
    problem_.highest_order = std::clamp((samples / 3 - 3) / 2, 1, highest_order);
    if (const auto& shape = options_.shape; shape && !shape->is_spline()) {
      if (shape->order < 1) refuse("order ", shape->order, ", expected at least 1");
      if (shape->order > problem_.highest_order)
        refuse("order ", shape->order, " from ", samples, " samples, expected at most ",
               problem_.highest_order);
    }
    if (std::ranges::all_of(result_.datasets,
                            [](const Characterisation& is) { return is.sample_time_s > shows_creep_s; }))
      options_.creep_per_decade = options_.creep_per_decade.value_or(0.0);
    problem_.knots = knot_places(datasets(), problem_.observed);
    problem_.most_pieces = std::min(most_pieces, (samples / 3 - 3) / 2 - 2);
    // A delay is searched only if a dataset has over 100 samples per cycle. With fewer samples, a delay looks
    // like a wider loop.
    for (const Characterisation& is : result_.datasets)
      if (static_cast<double>(is.samples) > 100.0 * static_cast<double>(is.cycles))
        problem_.sample_time_s = problem_.sample_time_s > 0.0
                                     ? std::min(problem_.sample_time_s, is.sample_time_s)
                                     : is.sample_time_s;
  }

  // Decides if the model has creep: compares the held-out errors of a search with creep and one without.
  void choose_creep(const Problem& finer) {
    SearchResult& found = result_.search;
    found = search(problem_, finer, options_);
    if (options_.creep_per_decade || found.trial.creep_per_decade == 0.0 || !options_.go_on()) return;
    IdentifyOptions none = options_;
    none.creep_per_decade = 0.0;
    result_.alternative = search(problem_, finer, none);
    if (options_.go_on() && found.score() > worth_creep * result_.alternative->score())
      std::swap(found, *result_.alternative);
  }

  void fit_all() {
    Folds one_fold = result_.folds;
    const Problem all = options_.go_on() ? unfolded(problem_, datasets(), one_fold) : problem_;
    SeparableFit fit(all, result_.search.shape, SeparableFit::fine_scan);
    Trial& trial = result_.search.trial;
    const Fitted fitted = fit_to_all(fit, trial);
    result_.parameters = fitted.parameters;
    result_.parameters.input_unit = datasets().front().input_unit;
    result_.parameters.output_unit = datasets().front().output_unit;
    if (!fitted.valid)
      refuse(
          "no model with an inverse fits: a branch decreases for every k_ascending and k_descending; check "
          "that the dataset is a hysteresis loop");
    result_.delay_s = trial.delay_s;
    result_.creep = creep_of(trial.creep_per_decade);
    result_.memories = trial.memories;
    result_.offsets = fitted.offsets;
    result_.drifts = fitted.drifts;
    for (std::size_t i = 0; i < datasets().size(); ++i) result_.gains.push_back(trial.gain(i));
    measure_span(result_, given_, options_.unseen);
    result_.held_out_rms = result_.search.held_out;
    judge(result_, datasets());
    if (!std::isfinite(result_.overall.rms))
      refuse("the error of the best model is not finite, expected a dataset that a model can describe");
  }

  IdentifyOptions options_;
  model::Symmetry symmetry_ = model::Symmetry::none;
  const std::vector<Dataset>& given_;
  std::vector<Dataset> without_unseen_;  // datasets without unseen samples; empty if all are seen
  std::vector<Dataset> folded_;          // datasets with folded inputs; empty if symmetry is not even
  Problem problem_;
  Folds held_out_;  // folds that the search holds out
  Identified result_;
};

// Returns the butterfly if its error is so small that it justifies the output map; otherwise returns `plain`.
Identified better_of(const Identified& plain, Identified butterfly) {
  const bool held_out = plain.held_out_rms && butterfly.held_out_rms;
  const double before = held_out ? *plain.held_out_rms : plain.overall.rms;
  const double after = held_out ? *butterfly.held_out_rms : butterfly.overall.rms;
  if (!(after < worth_a_map * before)) return plain;
  butterfly.search.steps.insert(butterfly.search.steps.begin(), {{Quantity::Kind::output_map},
                                                                 plain.overall.rms,
                                                                 butterfly.overall.rms,
                                                                 plain.held_out_rms,
                                                                 butterfly.held_out_rms});
  return butterfly;
}

Identified identify_near_zero(const std::vector<Dataset>& datasets, const IdentifyOptions& options) {
  const IdentifyDatasets curves = [](const std::vector<Dataset>& given,
                                     const IdentifyOptions& curve_options) {
    return Identification(given, curve_options).run();
  };
  if (options.output == ShapeOfOutput::butterfly) return identify_butterfly(datasets, options, curves);
  const bool may_be = options.output == ShapeOfOutput::automatic && !datasets.empty() &&
                      std::ranges::all_of(datasets, passes_valley);
  if (!may_be) return curves(datasets, options);
  std::exception_ptr reason;  // exception of the first search that fails
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

void measure_span(Identified& identified, const std::vector<Dataset>& datasets,
                  const std::vector<std::vector<bool>>& unseen) {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  for (std::size_t i = 0; i < datasets.size(); ++i)
    for (std::size_t j = 0; j < datasets[i].size(); ++j) {
      if (!unseen.empty() && unseen[i][j]) continue;
      const double output = (datasets[i].output[j] - identified.offsets[i]) / identified.gains[i];
      lo = std::min(lo, output);
      hi = std::max(hi, output);
    }
  identified.output_span = hi - lo;
}

void judge(Identified& identified, const std::vector<Dataset>& datasets) {
  identified.errors.clear();
  identified.overall = {};
  double square = 0.0;
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    const ErrorNorms errors = ErrorNorms::of(predict(identified, datasets, i), datasets[i].output);
    identified.errors.push_back(errors);
    identified.overall.max = std::max(identified.overall.max, errors.max);
    square += errors.rms * errors.rms * static_cast<double>(datasets[i].size());
  }
  identified.overall.rms = std::sqrt(square / static_cast<double>(samples_of(datasets)));
}

Identified identify(const std::vector<Dataset>& datasets, IdentifyOptions options) {
  std::ranges::for_each(datasets, check_limits);
  if (!datasets.empty() && std::ranges::all_of(datasets, moves_one_way))
    refuse(
        "the input only rises or only falls: the record has no loop; expected an input with turning points");
  const bool one_zero = options.common_zero && datasets.size() > 1;
  const std::vector<double> references = reference_outputs(datasets, one_zero);
  if (std::ranges::all_of(references, [](double reference) { return reference == 0.0; }))
    return identify_near_zero(datasets, options);
  // Far from a common zero, a gain acts like an offset. A common zero therefore needs a common gain.
  options.common_gain = options.common_gain || one_zero;
  std::vector<Dataset> near_zero = datasets;
  move_outputs(near_zero, references, -1.0);
  Identified found = identify_near_zero(near_zero, options);
  move_outputs(found, references);
  return found;
}

}  // namespace hystcan::identification
