// What the commands that drive axes on a real bus share: from the first SYNC to the safe command on the way
// out.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/live.h"
#include "config/config.h"
#include "controller/controller.h"

namespace hystcan::app {

/// Says on the log what becomes of each axis.
class StateLog {
 public:
  explicit StateLog(const config::Config& config);
  void add(const controller::CycleRecord& record);
  /// What the nodes said by emergency, and why one could not be set up: the first hundred.
  const std::vector<std::string>& events() const { return events_; }

 private:
  void add_event(const controller::CycleRecord& record);

  std::vector<std::string> names_;
  std::vector<std::string> nodes_;
  std::vector<controller::AxisState> states_;
  std::vector<std::string> events_;
};

/// Runs the controller until `is_done`, asked every 20 ms and told the seconds since start, or until a
/// signal; then every axis ramps to its safe drive and switches off. A second signal does not wait for the
/// ramp. The safe command goes out on every way out, an exception's too.
void run_live(LiveLoop& loop, controller::Controller& controller, bool clear_faults,
              const std::function<bool(double run_s)>& is_done);

}  // namespace hystcan::app
