// Reads and writes memory files: the state of a hysteresis model, in the TOML table [memory]. The page
// docs/file_formats.md lists the keys.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/document/format.h"
#include "model/any_model.h"
#include "model/output_creep.h"

namespace hystcan::config {

/// Reads the memory of `model` from a memory file, saved or written by hand. `Model` is a kind of model whose
/// memory consists of branches. `capacity` is the maximum number of branches. Throws Error if the file is
/// invalid.
template <class Model>
model::HysteresisState load_memory(const std::filesystem::path& file, const Model& model,
                                   std::size_t capacity);
model::PlayState load_memory(const std::filesystem::path& file, const model::PrandtlIshlinskii& model,
                             std::size_t capacity);
/// Returns the text of a memory file. load_memory() reads exactly the same state from this text. A caller may
/// append keys, which then belong to the table [memory].
template <class Model>
std::string memory_text(const Model& model, const typename Model::State& state) {
  std::vector<char> buffer(4096);
  std::string_view table;
  while ((table = model.save(state, buffer)).empty()) buffer.resize(2 * buffer.size());
  return std::string(format_line).append("\n").append(table);
}
/// The state of an axis that a controller saved when it stopped without a crash. The file is a memory file
/// with the additional table [stop].
struct SavedState {
  model::HysteresisState memory;
  std::vector<std::vector<double>> learnt;  ///< corrections learnt for each segment of the reference
};
/// Reads a saved state. Throws Error if the file is invalid or incomplete, or if the state belongs to another
/// model.
SavedState load_state(const std::filesystem::path& file, const model::Hysteresis& model);

/// Reads the state of the creep from a memory file of any kind. `h` is the present output of the hysteresis.
/// Returns nullopt if the file has no creep. Throws Error if the file is invalid, or if its number of creep
/// values differs from the number of lags of `creep`.
std::optional<model::HeldCreep::State> load_creep_memory(const std::filesystem::path& file,
                                                         const model::OutputCreep& creep, double h);
/// Returns the lines with the state of the creep, to append to the table [memory] of a memory file.
/// load_creep_memory() reads exactly the same state from these lines.
std::string creep_memory_text(const model::HeldCreep::State& state);

}  // namespace hystcan::config
