// Memory files ([memory]): docs/file_formats.md lists the keys.
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

/// Reads a saved or hand-written memory of `model`, whose kind has branches. Throws Error.
template <class Model>
model::HysteresisState load_memory(const std::filesystem::path& file, const Model& model,
                                   std::size_t capacity);
model::PlayState load_memory(const std::filesystem::path& file, const model::PrandtlIshlinskii& model,
                             std::size_t capacity);
/// Returns the text of a memory file, from which load_memory() restores the same bits. Any appended text
/// belongs to [memory].
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
  std::vector<std::vector<double>> learnt;  ///< controller::Learning::table(); empty if nothing was learnt
};
/// Throws Error, also if the state belongs to another model.
SavedState load_state(const std::filesystem::path& file, const model::Hysteresis& model);

/// Reads the creep from a memory file of any kind; `h` is the output of the hysteresis. nullopt if the file
/// has no creep. Throws Error, also if the number of lags differs.
std::optional<model::HeldCreep::State> load_creep_memory(const std::filesystem::path& file,
                                                         const model::OutputCreep& creep, double h);
/// Returns the lines that load_creep_memory() reads, exact to the bit. They belong at the end of [memory].
std::string creep_memory_text(const model::HeldCreep::State& state);

}  // namespace hystcan::config
