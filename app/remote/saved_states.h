// What each axis remembers, kept in a file over a clean stop: NAME.state.toml in state_dir, a memory file
// with the correction learnt so far. A file tells the truth only until the actuator is driven again: it is
// removed then, and written anew, in one step, at the next clean stop.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/files/model_file.h"
#include "config/schema/config.h"
#include "controller/controller.h"

namespace hystcan::app {

class SavedStates {
 public:
  /// Throws config::Error where an axis is to restore what cannot be: no file, or one of another model.
  explicit SavedStates(const config::Config& config);

  void restore(controller::Controller& controller) const;
  /// The axis is driven: its file is removed.
  void forget(std::size_t axis);
  /// Every axis that was stopped cleanly. What can't be written is a warning.
  void save(const controller::Controller& controller) const;

 private:
  struct Saved {
    std::filesystem::path file;  ///< empty: nothing is saved
    std::optional<config::SavedState> state;
    bool forgotten = false;
  };
  std::vector<Saved> axes_;
};

}  // namespace hystcan::app
