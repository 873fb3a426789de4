// Model files ([hysteresis]): docs/file_formats.md lists the keys.
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

/// Returns true if the file has a model table. Throws Error if it is not valid TOML.
bool is_model_file(const std::filesystem::path& file);

/// Reads and checks a model of any kind. Throws Error.
model::AnyModel load_any_model(const std::filesystem::path& file);
model::AnyParameters load_any_parameters(const std::filesystem::path& file);

/// Reads and checks a model, which must be of the kind recursive-memory. Throws Error.
model::HysteresisParameters load_model(const std::filesystem::path& file);

/// Like load_model(), without the check that every branch increases (model::Hysteresis::beyond_limit).
model::Hysteresis load_model_beyond_limit(const std::filesystem::path& file);

/// [identification] of a model file, optional: how well the model fits the dataset from which it was
/// identified.
struct IdentifiedFrom {
  std::size_t samples = 0;
  double delay_s = 0.0;      ///< delay of the output after the input
  double rms_percent = 0.0;  ///< RMS error, percent of the dataset's output span
  double max_percent = 0.0;
  std::optional<identification::Misfit> misfit{};
};

/// Returns the text of a model file, from which load_model() reads exactly the same parameters. `from`:
/// nullopt if the model was not identified.
std::string model_text(const model::HysteresisParameters& parameters,
                       const std::optional<IdentifiedFrom>& from,
                       const std::optional<model::Dynamics>& dynamics = {},
                       const std::optional<model::OutputCreep::Config>& creep = {});

/// Reads the delay of [identification], [dynamics] and [creep] from a model file of any kind; each may be
/// missing. Throws Error.
identification::Lag load_lag(const std::filesystem::path& file);

/// Reads the model's residual on its records, in um if its outputs are lengths; nullopt if the file does not
/// contain it. Throws Error.
std::optional<identification::Misfit> load_misfit(const std::filesystem::path& file);

}  // namespace hystcan::config
