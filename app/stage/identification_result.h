// Formats the results of `hystcan identify` and `hystcan validate` as a model file and as JSON.
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

/// Returns the text of the model file. Its comments contain the findings and the datasets from which the
/// model was identified.
std::string identified_model_text(const identification::Identified& identified,
                                  const std::vector<identification::Dataset>& datasets,
                                  const std::vector<std::string>& findings);
/// Returns the results of `identify --json`. Errors are in percent of the output's span.
nlohmann::json identification_json(const identification::Identified& identified,
                                   const std::vector<std::string>& findings);

/// Return the table [creep] or [dynamics] of a model file as JSON; null if the model does not have it.
nlohmann::json json_of(const std::optional<model::OutputCreep::Config>& creep);
nlohmann::json json_of(const std::optional<model::Dynamics>& dynamics);

struct ValidationOptions {
  identification::Lag lag;
  /// Initial memory and offset are estimated from the samples of this duration at the beginning; `nullopt`:
  /// from all samples.
  std::optional<double> estimate_s;
  bool estimates_offset = true;
  std::optional<model::HysteresisState> memory;    ///< memory at the first sample; `nullopt`: it is estimated
  std::optional<model::HeldCreep::State> crept{};  ///< creep at the first sample; `nullopt`: it has settled
};

/// Describes creep, for example "creep of 2.3 % per decade from 10 ms to 3 s".
std::string creep_text(const model::OutputCreep::Config& creep);

/// The prediction of a dataset by a model, and its errors.
struct Validation {
  identification::MemoryEstimate start;
  identification::Lag lag;
  std::vector<double> predicted;
  /// Number of samples from which memory and offset were estimated. `rest` excludes these samples.
  std::size_t estimated_from = 0;
  identification::ErrorNorms all, rest;
  double output_span = 0.0;
  std::vector<identification::RateError> by_rate;
  std::size_t outside = 0;  ///< number of samples with an input beyond the thresholds of the model

  bool has_rest() const { return estimated_from > 0 && estimated_from < predicted.size(); }
};

/// Predicts the dataset with the model and computes the errors. Throws std::invalid_argument if the output is
/// constant, if the delay is longer than the dataset, or if `options` contain dynamics and the dataset is not
/// evenly sampled.
Validation validate(const model::Hysteresis& model, const identification::Dataset& dataset,
                    ValidationOptions options);
nlohmann::json validation_json(const Validation& validation);

}  // namespace hystcan::app
