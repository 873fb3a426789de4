// Drives one axis by an excitation, on the bus or with the twin in virtual time, for `excite` and `tune`.
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
  std::string axis;       ///< empty: the first axis
  std::string interface;  ///< empty: the configured interface
  bool rehearse = false;
  bool clear_faults = false;
};

/// Adds --axis, --interface, --clear-faults and --rehearse.
void add_open_loop_options(CLI::App& command, OpenLoopOptions& options);

/// Longer than any start-up or ramp down: a run that takes longer would never end.
inline constexpr double patience_s = 60.0;
/// Runs in virtual time until is_done(), `limit_s` or a signal, then until every axis is safe.
void run_and_stop(rehearsal::Rehearsal& rehearsal, double limit_s, const std::function<bool()>& is_done);

/// Returns the configuration with only the chosen axis; the other axes are not driven. The twin keeps all
/// axes, as on a real bus.
config::Config chosen_axis_of(config::Config config, const OpenLoopOptions& options);

/// Returns the configuration with the excitation as the drive of its one axis, instead of the reference.
/// Throws std::invalid_argument if the gate would limit the drive.
config::Config in_open_loop(config::Config config, const controller::Excitation::Config& excitation);

/// The axis at the end of the run, and the closing lines about a real bus.
struct OpenLoopEnd {
  controller::Axis axis;
  std::vector<std::string> closing{};

  /// Throws RunError if the excitation did not finish; `afterwards` describes the output that remains.
  void require_finished(const std::string& axis_name, const std::string& afterwards) const;
};

/// Runs the excitation of the one axis of `config` until it ends, or until a fault or a signal. Then the axis
/// ramps to its safe drive and switches off. `on_record` receives every cycle record; on a real bus, another
/// thread calls it.
OpenLoopEnd drive_in_open_loop(const config::Config& config, const twin::Config& twin,
                               const OpenLoopOptions& options,
                               const std::function<void(const controller::CycleRecord&)>& on_record);

/// Returns true if the axis follows its excitation and has a sample.
bool shows_position(const controller::AxisReport& report);

}  // namespace hystcan::app
