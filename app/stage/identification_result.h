// The results of `hystcan identify` and `hystcan validate`: the model file and the numbers of --json.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "identification/dataset.h"
#include "identification/identify.h"
#include "identification/prediction.h"

namespace hystcan::app {

/// Returns the text of the model file, with the findings as comments. `datasets`: the source of the model.
std::string identified_model_text(const identification::Identified& identified,
                                  const std::vector<identification::Dataset>& datasets,
                                  const std::vector<std::string>& findings);
/// Returns the results as JSON, with errors in percent of the output's span.
nlohmann::json identification_json(const identification::Identified& identified,
                                   const std::vector<std::string>& findings);

/// Return the tables of a model file; null if the model has no such table.
nlohmann::json json_of(const std::optional<model::OutputCreep::Config>& creep);
nlohmann::json json_of(const std::optional<model::Dynamics>& dynamics);

struct ValidationOptions {
  identification::Lag lag;
  std::optional<double> estimate_s;  ///< duration of the first samples, from which initial memory and offset
                                     ///< are estimated; `nullopt`: all samples
  bool estimates_offset = true;
  std::optional<model::HysteresisState> memory;    ///< memory at the first sample, used instead of an
                                                   ///< estimate
  std::optional<model::HeldCreep::State> crept{};  ///< state of the creep that belongs to `memory`;
                                                   ///< `nullopt`: the creep has settled
};

/// Returns, for example, "creep of 2.3 % per decade from 10 ms to 3 s".
std::string creep_text(const model::OutputCreep::Config& creep);

/// The errors of a model's prediction of a dataset.
struct Validation {
  identification::MemoryEstimate start;
  identification::Lag lag;
  std::vector<double> predicted;
  std::size_t estimated_from = 0;  ///< number of samples used for the estimate, which are excluded from the
                                   ///< errors
  identification::ErrorNorms all, rest;
  double output_span = 0.0;
  std::vector<identification::RateError> by_rate;
  std::size_t outside = 0;  ///< number of samples beyond the thresholds

  bool has_rest() const { return estimated_from > 0 && estimated_from < predicted.size(); }
};

/// Throws std::invalid_argument if the output is constant, if the delay is longer than the dataset, or if
/// dynamics are given and the dataset is not evenly sampled.
Validation validate(const model::Hysteresis& model, const identification::Dataset& dataset,
                    ValidationOptions options);
nlohmann::json validation_json(const Validation& validation);

}  // namespace hystcan::app
