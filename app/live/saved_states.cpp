#include "app/live/saved_states.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <string>
#include <system_error>
#include <vector>

#include "base/error.h"
#include "base/output_file.h"
#include "config/files/memory_file.h"

namespace hystcan::app {
namespace {

using controller::MemorySource;

/// Returns the learnt correction of an axis as TOML, with one table for each segment of the reference. The
/// controller learns only in segments that repeat. The table of any other segment has no values.
std::string learnt_text(const controller::Learning* learning) {
  std::string text;
  if (learning == nullptr) return text;
  for (const std::vector<double>& segment : learning->table())
    text += fmt::format("[[learning]]\ncorrection_um = [{:.6g}]\n\n", fmt::join(segment, ", "));
  return text;
}

std::string memory_text(const controller::ControlLaw& law, const controller::Learning* learning) {
  return fmt::format(
      "# The memory of the actuator at a clean stop. The controller removes this file when it drives again.\n"
      "{}\n{}"
      "[stop]  # The last table: without it the file is incomplete.\nreason = \"stopped\"\n",
      config::memory_text(law.model(), law.memory()), learnt_text(learning));
}

}  // namespace

SavedStates::SavedStates(const config::Config& config) {
  const std::filesystem::path& folder = config.controller.state_folder;
  axes_.resize(config.axes.size());
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const config::AxisConfig& axis = config.axes[i];
    if (!folder.empty()) axes_[i].file = folder / (axis.wire.name + ".state.toml");
    const bool restores = axis.control.start_up == MemorySource::restore;
    if (restores && folder.empty())
      throw Error(
          config.file,
          fmt::format("axis {} has start_up = \"restore\", which reads a saved memory", axis.wire.name),
          expect("state_dir in [controller]"));
    if (restores && !std::filesystem::exists(axes_[i].file))
      throw Error(
          axes_[i].file, "the file is missing, so the last stop was not clean",
          {.remedy =
               "set start_up = \"wipe\" in [axis.control] for the next start, which then needs no file"});
    if (axes_[i].file.empty() || !std::filesystem::exists(axes_[i].file)) continue;
    try {
      axes_[i].state = config::load_state(axes_[i].file, model::Hysteresis(axis.control.law.model));
    } catch (const Error& error) {
      if (restores) throw;
      spdlog::warn("the saved state is not used: {}", error.what());
    }
  }
}

void SavedStates::restore(controller::Controller& controller) const {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto& state = axes_[i].state;
    if (!state) continue;
    controller::Axis& axis = controller.axis(i);
    axis.restore(state->memory);
    controller::ClosedLoop* loop = axis.closed_loop();
    controller::Learning* learning = loop == nullptr ? nullptr : loop->learning();
    if (!state->learnt.empty() && (learning == nullptr || !learning->restore(state->learnt)))
      spdlog::warn("{}: the saved correction belongs to another reference and is not used",
                   axes_[i].file.string());
  }
}

void SavedStates::forget(std::size_t axis) {
  if (axes_[axis].file.empty() || axes_[axis].forgotten) return;
  axes_[axis].forgotten = true;
  std::error_code error;
  std::filesystem::remove(axes_[axis].file, error);
  if (error)
    spdlog::warn(
        "{}: cannot be removed: {}; do not use start_up = \"restore\", because the file is out of date",
        axes_[axis].file.string(), error.message());
}

void SavedStates::save(const controller::Controller& controller) const {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const controller::ControlLaw* law = controller.axis(i).law_to_save();
    if (law == nullptr || axes_[i].file.empty()) continue;
    try {
      OutputFile file(axes_[i].file, OutputFile::Kind::durable);
      file.write(memory_text(*law, controller.axis(i).closed_loop()->learning()));
      file.commit();
    } catch (const RunError& error) {
      spdlog::warn("{}; do not use start_up = \"restore\" at the next start, because the memory is not saved",
                   error.what());
    }
  }
}

}  // namespace hystcan::app
