// Model files ([hysteresis]) and memory files ([memory]): docs/configuration.md lists the keys.
#pragma once

#include <filesystem>

#include "controller/control/adaptation.h"
#include "model/any_model.h"

namespace hystcan::config {

/// True where the file is TOML and has the table of a model. Throws Error where it is no TOML.
bool is_model_file(const std::filesystem::path& file);

/// Reads and checks a model of any kind. Throws Error.
model::AnyModel load_any_model(const std::filesystem::path& file);
model::AnyParameters load_any_parameters(const std::filesystem::path& file);

/// The same where only the recursive-memory model will do.
model::HysteresisParameters load_model(const std::filesystem::path& file);

/// The same without the check that every branch increases (model::Hysteresis::beyond_limit).
model::Hysteresis load_model_beyond_limit(const std::filesystem::path& file);

/// [identification] of a model file, optional: how well the model fits the record that it comes from.
struct IdentifiedFrom {
  std::size_t samples = 0;
  double delay_s = 0.0;      ///< of the output behind the input
  double rms_percent = 0.0;  ///< of the record's output span
  double max_percent = 0.0;
};

/// A model file. Read back, it gives the same parameters to the bit.
std::string model_text(const model::HysteresisParameters& parameters, const IdentifiedFrom& from);

/// Zeros where the file has none. Throws Error.
IdentifiedFrom load_identified_from(const std::filesystem::path& file);

/// Reads a memory that belongs to `model`: one that was saved, or one written by hand. Throws Error.
template <class Law>
model::HysteresisState load_memory(const std::filesystem::path& file, const model::MemoryModel<Law>& model,
                                   std::size_t capacity);
/// What a controller saved of an axis at its clean stop: a memory file with [correction] and [stop].
struct SavedState {
  model::HysteresisState memory;
  controller::ModelCorrection correction;
};
/// Throws Error, also where it is of another model.
SavedState load_state(const std::filesystem::path& file, const model::Hysteresis& model);

model::PlayState load_memory(const std::filesystem::path& file, const model::PrandtlIshlinskii& model,
                             std::size_t capacity);

}  // namespace hystcan::config
