// Drives one axis with an excitation in open loop, for `hystcan excite` and `hystcan tune`. The run is on the
// bus, or with the twin in virtual time.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/schema/config.h"
#include "controller/control/axis.h"
#include "controller/cycle_record.h"
#include "controller/reference/excitation.h"
#include "rehearsal/rehearsal.h"

namespace CLI {
class App;
}  // namespace CLI

namespace hystcan::app {

struct OpenLoopOptions {
  std::filesystem::path config;
  std::string axis;       ///< name of the axis; empty: the first axis
  std::string interface;  ///< CAN interface; empty: the configured one
  bool rehearse = false;
  bool clear_faults = false;
};

/// Adds the options --axis, --interface, --clear-faults and --rehearse.
void add_open_loop_options(CLI::App& command, OpenLoopOptions& options);

/// Time limit in s for a start-up or a ramp down, so that a run always ends. Every correct start-up and ramp
/// is shorter.
inline constexpr double patience_s = 60.0;
/// Runs in virtual time until is_done() returns true, `limit_s` is over, or a signal arrives. Then continues
/// until every axis is at its safe drive.
void run_and_stop(rehearsal::Rehearsal& rehearsal, double limit_s, const std::function<bool()>& is_done);

/// Returns a configuration of the controller that drives only the chosen axis. It lists the other axes as
/// resting: their amplifiers stay at their safe drives. The twin must still simulate all axes of the original
/// configuration, because a real bus has all nodes, too.
config::Config chosen_axis_of(config::Config config, const OpenLoopOptions& options);

/// Returns the configuration of one axis with `excitation` as its drive, instead of a reference. Throws
/// std::invalid_argument if the excitation exceeds the limits of the drive or of its slew rate.
config::Config in_open_loop(config::Config config, const controller::Excitation::Config& excitation);

/// The state of the axis at the end of the run. After a run on a real bus, also lines about the bus.
struct OpenLoopEnd {
  controller::Axis axis;
  std::vector<std::string> closing{};

  /// Throws RunError if the excitation did not finish. `afterwards`: text that says what was written.
  void require_finished(const std::string& axis_name, const std::string& afterwards) const;
};

/// Drives the axis of `config` until the excitation ends, a fault occurs or a signal arrives. Then the axis
/// ramps to its safe drive and switches off. `on_record` is called with every cycle record; on a real bus,
/// another thread calls it.
OpenLoopEnd drive_in_open_loop(const config::Config& config, const twin::Config& twin,
                               const OpenLoopOptions& options,
                               const std::function<void(const controller::CycleRecord&)>& on_record);

/// Returns true if the axis follows the excitation and the controller received its position in this cycle.
bool shows_position(const controller::AxisReport& report);

}  // namespace hystcan::app
