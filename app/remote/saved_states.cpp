#include "app/remote/saved_states.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "app/io/write_all.h"

namespace hystcan::app {
namespace {

using controller::StartUp;

std::string memory_text(const controller::ControlLaw& law) {
  std::vector<char> buffer(model::Hysteresis::saved_size());
  const controller::ModelCorrection& correction = law.correction();
  return fmt::format(
      "# The memory of the actuator at a clean stop. The controller removes this file when it drives again.\n"
      "[correction]\ngain = {:.17}\noffset_um = {:.17}\n\n{}\n"
      "[stop]  # The last table: without it the file is incomplete.\nreason = \"stopped\"\n",
      correction.gain, correction.offset_um, law.model().save(law.memory(), buffer));
}

bool write_to_disk(int descriptor, std::string_view text) {
  std::size_t done = 0;
  return write_all(descriptor, text, done) == 0 && fsync(descriptor) == 0;
}

bool sync_folder(const std::filesystem::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool synced = fsync(descriptor) == 0;
  close(descriptor);
  return synced;
}

/// Writes the file in one step: a reader finds all of it or nothing, also after a loss of power. The draft has
/// a new name, so that no file or link of another user is written.
bool replace(const std::filesystem::path& file, std::string_view text) {
  std::string draft = file.string() + ".XXXXXX";
  const int descriptor = mkstemp(draft.data());
  if (descriptor < 0) return false;
  const bool written = fchmod(descriptor, 0644) == 0 && write_to_disk(descriptor, text);
  if (close(descriptor) == 0 && written && std::rename(draft.c_str(), file.c_str()) == 0)
    return sync_folder(file.parent_path());
  unlink(draft.c_str());
  return false;
}

}  // namespace

SavedStates::SavedStates(const config::Config& config) {
  const std::filesystem::path& folder = config.controller.state_folder;
  axes_.resize(config.axes.size());
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const config::AxisConfig& axis = config.axes[i];
    if (!folder.empty()) axes_[i].file = folder / (axis.wire.name + ".state.toml");
    const bool restores = axis.control.start_up == StartUp::restore;
    if (restores && folder.empty())
      throw config::Error(
          fmt::format("{}: axis {} must restore its memory, expected state_dir in [controller]",
                      config.file.string(), axis.wire.name));
    if (restores && !std::filesystem::exists(axes_[i].file))
      throw config::Error(
          fmt::format("{}: there is no such file, so the last stop was not clean, expected it for "
                      "start_up = \"restore\"; start once with \"wipe\"",
                      axes_[i].file.string()));
    if (axes_[i].file.empty() || !std::filesystem::exists(axes_[i].file)) continue;
    try {
      axes_[i].state = config::load_state(axes_[i].file, model::Hysteresis(axis.control.law.model));
    } catch (const config::Error& error) {
      if (restores) throw;
      spdlog::warn("saved state not used: {}", error.what());
    }
  }
}

void SavedStates::restore(controller::Controller& controller) const {
  for (std::size_t i = 0; i < axes_.size(); ++i)
    if (axes_[i].state) controller.axis(i).restore(axes_[i].state->memory, axes_[i].state->correction);
}

void SavedStates::forget(std::size_t axis) {
  if (axes_[axis].file.empty() || axes_[axis].forgotten) return;
  axes_[axis].forgotten = true;
  std::error_code ignored;
  std::filesystem::remove(axes_[axis].file, ignored);
}

void SavedStates::save(const controller::Controller& controller) const {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const controller::ControlLaw* law = controller.axis(i).law_to_save();
    if (law == nullptr || axes_[i].file.empty()) continue;
    if (!replace(axes_[i].file, memory_text(*law)))
      spdlog::warn("{}: cannot be written; the next start must not restore", axes_[i].file.string());
  }
}

}  // namespace hystcan::app
