#include "app/stage/identification_result.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "base/words.h"
#include "can/dbc/text.h"
#include "config/document/toml_text.h"
#include "config/files/model_file.h"
#include "identification/misfit.h"
#include "identification/regression.h"

namespace hystcan::app {
namespace {

std::size_t samples_until(const identification::Dataset& dataset, const std::optional<double>& estimate_s) {
  std::size_t samples = 0;
  while (samples < dataset.size() &&
         (!estimate_s || dataset.time_s[samples] - dataset.time_s[0] <= *estimate_s))
    ++samples;
  return samples;
}

std::string time_text(double s) {
  return s < 1.0 ? fmt::format("{:.3g} ms", 1e3 * s) : fmt::format("{:.3g} s", s);
}

}  // namespace

nlohmann::json json_of(const std::optional<model::OutputCreep::Config>& creep) {
  if (!creep) return {};
  return {{"per_decade", creep->per_decade}, {"from_s", creep->from_s}, {"to_s", creep->to_s}};
}

nlohmann::json json_of(const std::optional<model::Dynamics>& dynamics) {
  if (!dynamics) return {};
  return {{"resonance_Hz", dynamics->mode.natural_frequency_Hz},
          {"damping_ratio", dynamics->mode.damping_ratio},
          {"delay_s", dynamics->delay_s}};
}

using identification::ErrorNorms;
using identification::Identified;

std::string identified_model_text(const Identified& identified,
                                  const std::vector<identification::Dataset>& datasets,
                                  const std::vector<std::string>& findings) {
  const double percent = 100.0 / identified.output_span;
  std::size_t samples = 0;
  for (const auto& dataset : identified.datasets) samples += dataset.samples;
  std::string text = "# Identified by hystcan identify.\n";
  for (const std::string& finding : findings)
    text += config::toml_comment(can::dbc::to_utf8("- " + finding + "\n"));
  return text + config::model_text(
                    identified.parameters,
                    config::IdentifiedFrom{samples, identified.delay_s, identified.overall.rms * percent,
                                           identified.overall.max * percent,
                                           identification::misfit_of(identified, datasets)},
                    identified.dynamics, identified.creep);
}

nlohmann::json identification_json(const Identified& identified, const std::vector<std::string>& findings) {
  const double percent = 100.0 / identified.output_span;
  const auto optional = [&](const std::optional<double>& value) {
    return value ? nlohmann::json(*value * percent) : nlohmann::json();
  };
  nlohmann::json datasets = nlohmann::json::array();
  for (std::size_t i = 0; i < identified.datasets.size(); ++i)
    datasets.push_back(
        {{"samples", identified.datasets[i].samples},
         {"cycles", identified.datasets[i].cycles},
         {"minor_fraction", identified.datasets[i].minor_fraction},
         {"noise_percent", identified.datasets[i].noise * percent},
         {"repeatability_percent", optional(identified.datasets[i].repeatability)},
         {"rms_percent", identified.errors[i].rms * percent},
         {"max_percent", identified.errors[i].max * percent},
         {"left_out_rms_percent", identified.left_out.empty() || identified.left_out[i].samples == 0.0
                                      ? nlohmann::json()
                                      : nlohmann::json(identified.left_out[i].rms() * percent)},
         {"offset", identified.offsets[i]},
         {"gain", identified.gains[i]},
         {"drift", identified.drifts[i]}});
  const auto range = [](const model::Interval& k) { return nlohmann::json{k.lo, k.hi}; };
  const model::Interval& thresholds = identified.parameters.input_range();
  const identification::CurveShape& shape = identified.search.shape;
  return {{"order", shape.order},
          {"basis", word_of(shape.is_spline() ? model::Basis::spline : model::Basis::chebyshev)},
          {"pieces", shape.is_spline() ? shape.knots.size() - 1 : 1},
          {"parameters", identified.parameter_count()},
          {"k_ascending", identified.parameters.k_ascending},
          {"k_descending", identified.parameters.k_descending},
          {"k_ascending_range", range(identified.pace_ascending)},
          {"k_descending_range", range(identified.pace_descending)},
          {"input_min", thresholds.lo},
          {"input_max", thresholds.hi},
          {"delay_s", identified.delay_s},
          {"delay_range_s", identified.delay_range
                                ? nlohmann::json{identified.delay_range->lo_s, identified.delay_range->hi_s}
                                : nlohmann::json()},
          {"dynamics", json_of(identified.dynamics)},
          {"creep", json_of(identified.creep)},
          {"creep_range", identified.creep_range
                              ? nlohmann::json{identified.creep_range->lo, identified.creep_range->hi}
                              : nlohmann::json()},
          {"output_span", identified.output_span},
          {"rms_percent", identified.overall.rms * percent},
          {"max_percent", identified.overall.max * percent},
          {"held_out_rms_percent", optional(identified.held_out_rms)},
          {"stopped", identified.stopped},
          {"records", datasets},
          {"findings", findings}};
}

std::string creep_text(const model::OutputCreep::Config& creep) {
  return fmt::format("creep of {:.3g} % per decade from {} to {}", 100.0 * creep.per_decade,
                     time_text(creep.from_s), time_text(creep.to_s));
}

Validation validate(const model::Hysteresis& model, const identification::Dataset& given,
                    ValidationOptions options) {
  const identification::Dataset dataset = model.symmetry() == model::Symmetry::even ? folded(given) : given;
  Validation result;
  result.lag = options.lag;
  const double delay_s = result.lag.delay();
  if (const double lasts_s = dataset.time_s.back() - dataset.time_s.front(); delay_s > lasts_s)
    throw std::invalid_argument(fmt::format(
        "the delay is {} s, expected at most the length of the dataset, {:g} s", delay_s, lasts_s));
  result.output_span = identification::span_of(dataset.output);
  if (!(result.output_span > 0.0)) throw std::invalid_argument("the output is constant");
  if (options.memory) {
    result.predicted = identification::predict(model, dataset, result.lag, *options.memory, options.crept);
  } else {
    result.estimated_from = samples_until(dataset, options.estimate_s);
    result.start =
        estimate_memory(model, dataset, result.lag, result.estimated_from, options.estimates_offset);
    result.predicted = identification::predict(model, dataset, result.lag, result.start.memory);
  }
  for (double& output : result.predicted) output += result.start.offset;
  result.all = ErrorNorms::of(result.predicted, dataset.output);
  result.rest = ErrorNorms::of(result.predicted, dataset.output, result.estimated_from);
  result.by_rate = errors_by_rate(dataset, result.predicted);
  for (const double input : dataset.input) result.outside += model.input_range().contains(input) ? 0 : 1;
  return result;
}

nlohmann::json validation_json(const Validation& validation) {
  const double percent = 100.0 / validation.output_span;
  const auto of_the_rest = [&](double error) {
    return validation.has_rest() ? nlohmann::json(error * percent) : nlohmann::json();
  };
  nlohmann::json rates = nlohmann::json::array();
  for (const auto& of : validation.by_rate)
    rates.push_back({{"input_per_s", of.speed}, {"rms_percent", of.rms * percent}, {"samples", of.samples}});
  return {{"samples", validation.predicted.size()},
          {"by_rate", rates},
          {"rms_percent", validation.all.rms * percent},
          {"max_percent", validation.all.max * percent},
          {"estimated_from_samples", validation.estimated_from},
          {"rest_rms_percent", of_the_rest(validation.rest.rms)},
          {"rest_max_percent", of_the_rest(validation.rest.max)},
          {"offset", validation.start.offset},
          {"delay_s", validation.lag.delay_s},
          {"dynamics", json_of(validation.lag.dynamics)},
          {"creep", json_of(validation.lag.creep)},
          {"output_span", validation.output_span},
          {"samples_outside_thresholds", validation.outside}};
}

}  // namespace hystcan::app
