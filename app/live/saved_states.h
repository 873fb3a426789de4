// Saves the hysteresis memory of each axis at a clean stop to the file NAME.state.toml in state_dir. The file
// also contains the learnt correction. The file is valid only until the actuator is driven again. At that
// time the file is removed; the next clean stop writes a new file in one atomic step.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/files/memory_file.h"
#include "config/files/model_file.h"
#include "config/schema/config.h"
#include "controller/controller.h"

namespace hystcan::app {

class SavedStates {
 public:
  /// Loads the saved files. Throws Error if an axis is configured to restore its memory, but its file is
  /// missing or belongs to another model.
  explicit SavedStates(const config::Config& config);

  void restore(controller::Controller& controller) const;
  /// Removes the file of an axis. Called when the axis is driven, because the hysteresis memory of the stage
  /// then differs from the memory in the file. Logs a warning if the file cannot be removed.
  void forget(std::size_t axis);
  /// Saves the hysteresis memory and the learnt correction of every axis that was stopped cleanly. Logs a
  /// warning if a file cannot be written.
  void save(const controller::Controller& controller) const;

 private:
  struct Saved {
    std::filesystem::path file;  ///< file of the axis; empty: its memory is not saved
    std::optional<config::SavedState> state;
    bool forgotten = false;
  };
  std::vector<Saved> axes_;
};

}  // namespace hystcan::app
