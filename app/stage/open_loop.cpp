#include "app/stage/open_loop.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <memory>

#include "app/live/live_loop.h"
#include "app/live/live_run.h"
#include "app/live/machine_setup.h"
#include "app/live/rehearsal_setup.h"
#include "app/live/report.h"
#include "app/live/state_log.h"
#include "app/live/stop_signal.h"
#include "app/stage/config_edit.h"
#include "app/stage/option_check.h"
#include "base/error.h"
#include "controller/telemetry.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {
namespace {

using controller::Excitation;
using OnRecord = std::function<void(const controller::CycleRecord&)>;

bool has_ended(const controller::Axis& axis) {
  return axis.report().point.finished || axis.state() == controller::AxisState::faulted;
}

OpenLoopEnd rehearse(const config::Config& config, const twin::Config& twin, const OnRecord& on_record) {
  rehearsal::Rehearsal rehearsal(rehearsal_setup(config, twin), on_record);
  run_and_stop(rehearsal, patience_s + Excitation(*config.axes[0].control.excitation).length_s(),
               [&] { return has_ended(rehearsal.controller().axis(0)); });
  return {rehearsal.controller().axis(0)};
}

OpenLoopEnd run_on_the_bus(const config::Config& config, const OpenLoopOptions& options,
                           const OnRecord& on_record) {
  LiveLoop loop(config.bus.interface);
  StateLog log(config, bus_log_sink());
  can::BusHealthLog bus_log(config.bus.interface, bus_log_sink());
  std::unique_ptr<controller::TelemetryThread> telemetry;
  controller::Controller controller(controller_config(config), config.database, loop.scheduler(),
                                    loop.attach_controller(),
                                    [&](const controller::CycleRecord& record) { telemetry->push(record); });
  check_interface(config, config.bus.interface);
  telemetry = std::make_unique<controller::TelemetryThread>([&](const controller::CycleRecord& record) {
    log.add(record);
    bus_log.write();
    on_record(record);
  });
  const Excitation::Config& excitation = *config.axes[0].control.excitation;
  spdlog::info("{} excitation of axis {}, {:.3g} s at {} Hz on {}; Ctrl-C ramps down and stops",
               name_of(excitation), config.axes[0].wire.name, Excitation(excitation).length_s(),
               config.controller.rate_Hz, config.bus.interface);
  run_live(loop, controller, bus_log,
           {.clear_faults = options.clear_faults,
            .is_done = [&](double) { return has_ended(controller.axis(0)); },
            .reload = {}});
  telemetry.reset();
  bus_log.write();
  return {controller.axis(0), describe(closing_of(controller, log.events()))};
}

}  // namespace

void add_open_loop_options(CLI::App& command, OpenLoopOptions& options) {
  command.add_option("--axis", options.axis, "name of the axis; default: the first one");
  CLI::Option* interface = add_checked(command, "--interface", options.interface, interface_name(),
                                       "CAN interface; default: as configured");
  CLI::Option* clear = command.add_flag("--clear-faults", options.clear_faults,
                                        "clear a latched fault of the amplifier before the start");
  command
      .add_flag("--rehearse", options.rehearse, "run on the simulated bus, with the twin, in virtual time")
      ->excludes(interface)
      ->excludes(clear);
}

void run_and_stop(rehearsal::Rehearsal& rehearsal, double limit_s, const std::function<bool()>& is_done) {
  constexpr auto stride = std::chrono::milliseconds(10);
  stop_at_a_signal();
  rehearsal.start();
  while (stop_signalled == 0 && rehearsal.time_s() <= limit_s && !is_done()) rehearsal.run_for(stride);
  rehearsal.controller().request_stop();
  for (const double asked_s = rehearsal.time_s();
       !rehearsal.controller().stopped() && rehearsal.time_s() < asked_s + patience_s;)
    rehearsal.run_for(stride);
}

config::Config chosen_axis_of(config::Config config, const OpenLoopOptions& options) {
  const config::AxisConfig& chosen = config.axes[index_of_axis(config, options.axis)];
  config::AxisConfig axis = chosen;
  for (const config::AxisConfig& other : config.axes) {
    if (&other == &chosen) continue;
    config.resting.push_back({other.wire, other.control.gate.safe_drive});
    // If axes share a node, the configuration may list the setup objects of this node at another axis. The
    // chosen axis needs these objects even if it is the only driven axis.
    if (other.wire.amplifier_node == axis.wire.amplifier_node && axis.wire.amplifier_setup.empty())
      axis.wire.amplifier_setup = other.wire.amplifier_setup;
    if (other.wire.sensor_node == axis.wire.sensor_node && axis.wire.sensor_setup.empty())
      axis.wire.sensor_setup = other.wire.sensor_setup;
  }
  config.axes = {std::move(axis)};
  config.axes[0].live_setpoint = false;
  if (!options.interface.empty()) config.bus.interface = options.interface;
  return config;
}

config::Config in_open_loop(config::Config config, const Excitation::Config& excitation) {
  controller::AxisConfig& control = config.axes[0].control;
  refuse_beyond({control.gate.drive_min, control.gate.drive_max}, control.gate.slew_per_s,
                Excitation(excitation));
  control.excitation = excitation;
  control.couplings.clear();
  return config;
}

void OpenLoopEnd::require_finished(const std::string& axis_name, const std::string& afterwards) const {
  if (axis.fault().cause != controller::Cause::none)
    throw RunError(describe(axis_name, axis.fault()), {.remedy = afterwards});
  if (!axis.report().point.finished) throw RunError(afterwards);
}

OpenLoopEnd drive_in_open_loop(const config::Config& config, const twin::Config& twin,
                               const OpenLoopOptions& options, const OnRecord& on_record) {
  return options.rehearse ? rehearse(config, twin, on_record) : run_on_the_bus(config, options, on_record);
}

bool shows_position(const controller::AxisReport& report) {
  return report.state == controller::AxisState::tracking && !report.sample_missing;
}

}  // namespace hystcan::app
