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

/// True if the file has the table of a model. Throws Error if it is not TOML.
bool is_model_file(const std::filesystem::path& file);

/// Reads and checks a model of any kind. Throws Error.
model::AnyModel load_any_model(const std::filesystem::path& file);
model::AnyParameters load_any_parameters(const std::filesystem::path& file);

/// Reads and checks a model that must be of the kind recursive-memory. Throws Error.
model::HysteresisParameters load_model(const std::filesystem::path& file);

/// Like load_model(), without the check that every branch increases (model::Hysteresis::beyond_limit).
model::Hysteresis load_model_beyond_limit(const std::filesystem::path& file);

/// [identification] of a model file, optional: how well the model fits the dataset that it was identified
/// from.
struct IdentifiedFrom {
  std::size_t samples = 0;
  double delay_s = 0.0;      ///< delay of the output after the input
  double rms_percent = 0.0;  ///< of the dataset's output span
  double max_percent = 0.0;
  std::optional<identification::Misfit> misfit{};
};

/// The text of a model file. load_model() reads exactly the same parameters from it. `from`: none if it is
/// not identified.
std::string model_text(const model::HysteresisParameters& parameters,
                       const std::optional<IdentifiedFrom>& from,
                       const std::optional<model::Dynamics>& dynamics = {},
                       const std::optional<model::OutputCreep::Config>& creep = {});

/// The delay of [identification], the [dynamics] and the [creep] of a model file of any kind, as far as it
/// has them. Throws Error.
identification::Lag load_lag(const std::filesystem::path& file);

/// What the model leaves of its records, in um where its outputs are lengths; none if the file does not say.
/// Throws Error.
std::optional<identification::Misfit> load_misfit(const std::filesystem::path& file);

}  // namespace hystcan::config
