// Reads and writes model files: the parameters of a hysteresis model, in the TOML table [hysteresis]. The
// page docs/file_formats.md lists the keys.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "identification/misfit.h"
#include "identification/prediction.h"
#include "model/any_model.h"
#include "model/dynamics.h"
#include "model/output_creep.h"

namespace hystcan::config {

/// Returns true if the file has the table [hysteresis]. Throws Error if the file is not valid TOML.
bool is_model_file(const std::filesystem::path& file);

/// Reads and checks a model of any kind. Throws Error if the file or the model is invalid.
model::AnyModel load_any_model(const std::filesystem::path& file);
model::AnyParameters load_any_parameters(const std::filesystem::path& file);

/// Reads and checks a model of the kind recursive-memory. Throws Error if the model is invalid or of another
/// kind.
model::HysteresisParameters load_model(const std::filesystem::path& file);

/// Reads a model of the kind recursive-memory like load_model(), but also accepts a model in which some
/// branches do not increase, because a convergence rate k exceeds its limit
/// (model::Hysteresis::beyond_limit).
model::Hysteresis load_model_beyond_limit(const std::filesystem::path& file);

/// The optional table [identification] of a model file: how well the model fits the dataset from which it was
/// identified.
struct IdentifiedFrom {
  std::size_t samples = 0;
  double delay_s = 0.0;      ///< delay from the input to the output
  double rms_percent = 0.0;  ///< RMS error of the model, percent of the dataset's output span
  double max_percent = 0.0;
  std::optional<identification::Misfit> misfit{};
};

/// Returns the text of a model file. load_model() reads exactly the same parameters from this text. `from` is
/// nullopt if the model was not identified from a dataset.
std::string model_text(const model::HysteresisParameters& parameters,
                       const std::optional<IdentifiedFrom>& from,
                       const std::optional<model::Dynamics>& dynamics = {},
                       const std::optional<model::OutputCreep::Config>& creep = {});

/// Reads the delay (key of [identification]) and the tables [dynamics] and [creep] from a model file of any
/// kind. Each of the three may be missing. Throws Error if the file is invalid.
identification::Lag load_lag(const std::filesystem::path& file);

/// Reads the residuals of the model in the records from which it was identified. They are in um if the
/// model's output is a length. Returns nullopt if the file has no residuals. Throws Error if the file is
/// invalid.
std::optional<identification::Misfit> load_misfit(const std::filesystem::path& file);

}  // namespace hystcan::config
