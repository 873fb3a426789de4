// One axis driven by an excitation, on the bus or with the twin in virtual time: what `excite` and `tune`
// share.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "config/schema/config.h"
#include "controller/control/axis.h"
#include "controller/cycle_record.h"
#include "controller/reference/excitation.h"

namespace hystcan::app {

struct OpenLoopOptions {
  std::filesystem::path config;
  std::string axis;       ///< empty: the first one
  std::string interface;  ///< empty: the configured one
  bool rehearse = false;
  bool clear_faults = false;
};

/// --axis, --interface, --clear-faults, --rehearse.
void add_open_loop_options(CLI::App& command, OpenLoopOptions& options);

/// The configuration with the chosen axis alone; in open loop it takes no live setpoints.
config::Config chosen_axis_of(config::Config config, const OpenLoopOptions& options);

/// The one axis of `config`, which is let go of its reference and given a drive. Throws std::invalid_argument
/// where the gate would not let the drive pass as it is.
config::Config in_open_loop(config::Config config, const controller::Excitation::Config& excitation);

/// `output` must be none of the files that the configuration was read from. Throws config::Error.
void refuse_to_overwrite_inputs(const std::filesystem::path& output, const std::filesystem::path& file,
                                const config::Config& config);

/// How it ended is told by the axis; of the bus there is something to tell where there was a real one.
struct OpenLoopEnd {
  controller::Axis axis;
  std::vector<std::string> closing{};

  /// Throws RunError where the excitation did not come to its end; `afterwards` says what is left of it.
  void require_finished(const std::string& axis_name, const std::string& afterwards) const;
};

/// Runs the excitation of the one axis of `config` to its end, to a fault or to a signal; then the axis ramps
/// to its safe drive and switches off. `on_record` has every cycle; on the bus another thread calls it.
/// A rehearsal has `twin`, whole, as the bus has all its nodes.
OpenLoopEnd drive_in_open_loop(const config::Config& config, const twin::Config& twin,
                               const OpenLoopOptions& options,
                               const std::function<void(const controller::CycleRecord&)>& on_record);

}  // namespace hystcan::app
