// Saves the memory of each axis at a clean stop: NAME.state.toml in state_dir is a memory file that also
// contains the learnt correction. The file is valid only until the actuator is driven again. It is then
// removed; the next clean stop writes a new one atomically.
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
  /// Throws Error if an axis must restore its memory and its file is missing or belongs to another model.
  explicit SavedStates(const config::Config& config);

  void restore(controller::Controller& controller) const;
  /// Removes the file of an axis that is being driven. Logs a warning if it can't be removed.
  void forget(std::size_t axis);
  /// Saves every axis that was stopped cleanly. Logs a warning if a file can't be written.
  void save(const controller::Controller& controller) const;

 private:
  struct Saved {
    std::filesystem::path file;  ///< empty: the axis is not saved
    std::optional<config::SavedState> state;
    bool forgotten = false;
  };
  std::vector<Saved> axes_;
};

}  // namespace hystcan::app
