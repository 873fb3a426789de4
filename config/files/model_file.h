// Model files ([hysteresis]) and memory files ([memory]): docs/file_formats.md lists the keys.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/document/format.h"
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

/// Reads a memory of `model` that was saved or written by hand. Throws Error. `Model`: one with branches.
template <class Model>
model::HysteresisState load_memory(const std::filesystem::path& file, const Model& model,
                                   std::size_t capacity);
model::PlayState load_memory(const std::filesystem::path& file, const model::PrandtlIshlinskii& model,
                             std::size_t capacity);
/// The text of a memory file: load_memory() restores it to the bit. What follows it belongs to [memory].
template <class Model>
std::string memory_text(const Model& model, const typename Model::State& state) {
  std::vector<char> buffer(4096);
  std::string_view table;
  while ((table = model.save(state, buffer)).empty()) buffer.resize(2 * buffer.size());
  return std::string(format_line).append("\n").append(table);
}
/// The state of an axis that a controller saved at a clean stop: a memory file with [stop].
struct SavedState {
  model::HysteresisState memory;
  std::vector<std::vector<double>> learnt;  ///< controller::Learning::table(); empty: nothing
};
/// Throws Error, also if the state belongs to another model.
SavedState load_state(const std::filesystem::path& file, const model::Hysteresis& model);

/// The creep of a memory file of any kind, where `h` is the output of its memory; none if it has no creep.
/// Throws Error, also if it is that of another number of lags.
std::optional<model::HeldCreep::State> load_creep_memory(const std::filesystem::path& file,
                                                         const model::OutputCreep& creep, double h);
/// The lines that load_creep_memory() reads, to the bit. They belong at the end of [memory].
std::string creep_memory_text(const model::HeldCreep::State& state);

}  // namespace hystcan::config
