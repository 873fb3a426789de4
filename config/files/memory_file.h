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
