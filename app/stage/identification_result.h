// What `hystcan identify` and `hystcan validate` give: model file, and the numbers of --json.
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

/// The text of the model file, with the findings as comments. `datasets`: it was identified from these.
std::string identified_model_text(const identification::Identified& identified,
                                  const std::vector<identification::Dataset>& datasets,
                                  const std::vector<std::string>& findings);
/// Errors in percent of the output's span.
nlohmann::json identification_json(const identification::Identified& identified,
                                   const std::vector<std::string>& findings);

/// Tables of a model file; null where it has none.
nlohmann::json json_of(const std::optional<model::OutputCreep::Config>& creep);
nlohmann::json json_of(const std::optional<model::Dynamics>& dynamics);

struct ValidationOptions {
  identification::Lag lag;
  std::optional<double> estimate_s;  ///< initial memory and offset from this many seconds; none: from all
  bool estimates_offset = true;
  std::optional<model::HysteresisState> memory;    ///< at the first sample, instead of an estimate
  std::optional<model::HeldCreep::State> crept{};  ///< beside this memory; none: settled
};

/// "creep of 2.3 % per decade from 10 ms to 3 s".
std::string creep_text(const model::OutputCreep::Config& creep);

/// How a model predicts a dataset.
struct Validation {
  identification::MemoryEstimate start;
  identification::Lag lag;
  std::vector<double> predicted;
  std::size_t estimated_from = 0;  ///< samples, which are not judged
  identification::ErrorNorms all, rest;
  double output_span = 0.0;
  std::vector<identification::RateError> by_rate;
  std::size_t outside = 0;  ///< samples beyond the thresholds

  bool has_rest() const { return estimated_from > 0 && estimated_from < predicted.size(); }
};

/// Throws std::invalid_argument if the output is constant, if the delay is longer than the dataset, or if
/// dynamics are given and the dataset is not evenly sampled.
Validation validate(const model::Hysteresis& model, const identification::Dataset& dataset,
                    ValidationOptions options);
nlohmann::json validation_json(const Validation& validation);

}  // namespace hystcan::app
