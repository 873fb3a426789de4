#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line/commands.h"
#include "app/live/answer_json.h"
#include "app/live/control_service.h"
#include "app/live/cycle_outlets.h"
#include "app/live/live_loop.h"
#include "app/live/live_run.h"
#include "app/live/machine_setup.h"
#include "app/live/realtime.h"
#include "app/live/rehearsal_setup.h"
#include "app/live/report.h"
#include "app/live/saved_states.h"
#include "app/live/socket_place.h"
#include "app/live/state_log.h"
#include "app/live/systemd_notifier.h"
#include "app/stage/open_loop.h"
#include "app/stage/option_check.h"
#include "base/error.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "config/schema/check.h"
#include "config/schema/config.h"
#include "config/schema/setpoint_warnings.h"
#include "config/schema/settings.h"
#include "controller/black_box.h"
#include "controller/control/statistics.h"
#include "controller/controller.h"
#include "controller/telemetry.h"
#include "rehearsal/rehearsal.h"
#include "runs/run_folder.h"

namespace hystcan::app {
namespace {

using controller::AxisState;

struct ControllerArguments {
  std::filesystem::path config;
  std::string interface;
  std::filesystem::path csv;
  std::filesystem::path record;
  double duration_s = 0.0;
  bool once = false;
  bool rehearse = false;
  bool clear_faults = false;
  bool json = false;
};

/// Processes the cycle records on the telemetry thread: counts and writes each record, and logs changes of
/// state. Each record is stored for `hystcan status` and in the black box (the last cycles, written to a file
/// after a fault) before the log is written.
class CycleRecorder {
 public:
  CycleRecorder(const config::Config& config, const SavedStates& states, const std::filesystem::path& csv)
      : log_(config, bus_log_sink()),
        lateness_(config.controller.lateness_warn, bus_log_sink()),
        bus_log_(config.bus.interface, bus_log_sink()),
        black_box_(config.controller.black_box, config::axis_names(config), bus_log_sink()),
        outlets_(config, runs::describe(config, config::settings(config.file), "controller"), bus_log_sink()),
        states_(states) {
    for (const config::AxisConfig& axis : config.axes) statistics_.emplace_back(axis.control, settle_s);
    if (!csv.empty()) csv_.emplace(csv, config::axis_names(config));
  }

  void consume(const controller::CycleRecord& record) {
    outlets_.put(record);
    black_box_.add(record);
    if (record.report.state >= AxisState::initialising) states_.forget(record.axis);
    service_.report_cycle(record.time_s);
    statistics_[record.axis].add(record.report);
    if (csv_) csv_->write(record);
    log_.add(record);
    lateness_.add(record);
    bus_log_.write();
  }

  const StateLog& log() const { return log_; }
  /// Returns the log of the bus state. The control thread gives the log the present state of the bus with
  /// sample(). After the telemetry thread ended, call write() of the log to print the last lines.
  can::BusHealthLog& bus_log() { return bus_log_; }
  CycleOutlets& outlets() { return outlets_; }
  controller::BlackBox& black_box() { return black_box_; }
  std::optional<std::string> close_csv() { return csv_ ? csv_->close() : std::nullopt; }
  const std::vector<controller::TrackingStatistics>& statistics() const { return statistics_; }

 private:
  StateLog log_;
  controller::LatenessLog lateness_;
  can::BusHealthLog bus_log_;
  controller::BlackBox black_box_;
  CycleOutlets outlets_;
  SavedStates states_;
  SystemdNotifier service_ = SystemdNotifier::from_environment();
  std::vector<controller::TrackingStatistics> statistics_;
  std::optional<controller::CsvLog> csv_;
};

bool all_axes(const controller::Controller& controller, auto predicate) {
  for (std::size_t i = 0; i < controller.axis_count(); ++i)
    if (!predicate(controller.axis(i))) return false;
  return true;
}

/// Returns true if the run can end because every axis has ended. An axis has ended if its reference is
/// finished, or if the axis is faulted or offline. `had_their_time`: the time limit for the start of the axes
/// is over. An axis that still waits to start is then ignored, but at least one axis must have ended.
bool nothing_left_to_do(const controller::Controller& controller, bool had_their_time) {
  const auto has_ended = [](const controller::Axis& axis) {
    return axis.report().point.finished || axis.state() == AxisState::faulted ||
           axis.state() == AxisState::offline;
  };
  const bool none_has_ended =
      all_axes(controller, [&](const controller::Axis& axis) { return !has_ended(axis); });
  if (none_has_ended) return false;
  return all_axes(controller, [&](const controller::Axis& axis) {
    return has_ended(axis) || (had_their_time && axis.state() == AxisState::waiting);
  });
}

std::filesystem::path socket_of(const config::Config& config) {
  const std::string& socket = config.controller.control_socket;
  if (socket == "none") return {};
  return socket.empty() ? default_socket(config.bus.interface) : std::filesystem::path(socket);
}

std::string results_text(const controller::Controller& controller, const StateLog& log,
                         const std::vector<controller::AxisOutcome>& outcomes,
                         const ControllerArguments& options, std::uint64_t dropped_records) {
  const controller::CycleCounters& counters = controller.counters();
  const BusClosing closing = closing_of(controller, log.events());
  if (options.json) {
    nlohmann::json axes = nlohmann::json::array();
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      axes.push_back(to_json(outcomes[i]));
      axes.back()["rejected_samples"] =
          to_json(can::rejected_frames("", controller.wired_axis(i).sensor.samples().checker()));
    }
    nlohmann::json results = as_json(counters);
    results.update({{"dropped_records", dropped_records},
                    {"timing", to_json(controller.timing())},
                    {"events", closing.events},
                    {"events_truncated", closing.events_truncated},
                    {"bus", to_json(closing)},
                    {"axes", axes}});
    return results.dump(2) + "\n";
  }
  std::string text = describe(counters) + "\n";
  if (counters.replaced_commands > 0)
    text += counted(counters.replaced_commands, "command") + " replaced by a newer one before transmission\n";
  if (!options.rehearse)  // a rehearsal has no timing to show: in virtual time, computing takes no time
    for (const std::string& line : describe(controller.timing())) text += line + "\n";
  for (const std::string& line : describe(closing)) text += line + "\n";
  for (const auto& outcome : outcomes) {
    text += describe(outcome) + "\n";
    for (const std::string& line : describe_segments(outcome)) text += line + "\n";
  }
  return text;
}

std::vector<controller::AxisOutcome> outcomes_of(
    const controller::Controller& controller, const std::vector<controller::TrackingStatistics>& statistics) {
  std::vector<controller::AxisOutcome> outcomes;
  for (std::size_t i = 0; i < controller.axis_count(); ++i)
    outcomes.push_back(
        controller::outcome_of(controller.wired_axis(i).wire.name, controller.axis(i), statistics[i]));
  return outcomes;
}

/// Throws RunError if the run failed. The message lists every fault; without a fault, it is the first other
/// reason, for example an axis that did not track. `was_enabled`: at least one axis was enabled when the run
/// was told to end. A run in which no axis tracked is successful if the user had disabled all axes and uses
/// neither --once nor --duration.
void require_success(const controller::Controller& controller, const StateLog& log,
                     const ControllerArguments& options, bool was_enabled,
                     const std::vector<controller::AxisOutcome>& outcomes) {
  std::string faults;
  for (const auto& outcome : outcomes)
    if (outcome.fault.cause != controller::Cause::none)
      faults += (faults.empty() ? "" : "; ") + describe(outcome.name, outcome.fault);
  if (!faults.empty()) throw RunError(faults);
  const bool was_to_track = options.once || options.duration_s > 0.0 || was_enabled;
  if (was_to_track && !log.has_any_tracked()) throw RunError("nothing was tracked: " + log.blocks_of(0));
  for (std::size_t i = 0; options.once && i < controller.axis_count(); ++i) {
    if (!log.has_tracked(i))
      throw RunError(fmt::format("axis {} did not track: {}", outcomes[i].name, log.blocks_of(i)));
    if (!controller.axis(i).report().point.finished)
      throw RunError(fmt::format("axis {} stopped before the end of its reference", outcomes[i].name));
  }
}

bool is_done(const controller::Controller& controller, const ControllerArguments& options, double run_s,
             double start_timeout_s) {
  return (options.duration_s > 0.0 && run_s > options.duration_s) ||
         (options.once && nothing_left_to_do(controller, run_s > start_timeout_s));
}

/// Runs the controller until every axis is at its safe drive. Returns true if at least one axis was enabled
/// when the end of the run was requested. After this function, the process still writes its files. If this
/// takes longer than 30 s, for example because a disk does not respond, the process is ended (ExitLimit).
bool run_to_the_end(LiveLoop& loop, controller::Controller& controller, ControlService& control,
                    CycleRecorder& recorder, const ControllerArguments& options, double start_timeout_s) {
  const ExitLimit limit(std::chrono::seconds(30));
  bool is_enabled = true;  // axes are enabled at the start; before_stop updates the value
  run_live(loop, controller, recorder.bus_log(),
           {.clear_faults = options.clear_faults,
            .is_done = [&](double run_s) { return is_done(controller, options, run_s, start_timeout_s); },
            .before_stop =
                [&] {
                  is_enabled = !all_axes(controller, [](const controller::Axis& axis) {
                    return axis.state() == AxisState::offline;
                  });
                },
            .reload = [&] { control.reload(); }});
  return is_enabled;
}

/// Starts the recording. Throws RunError if that fails, because a run that should be recorded must not run
/// unrecorded.
void start_recording(runs::Recorder& recorder) {
  try {
    spdlog::info("recording to {}", recorder.start().string());
  } catch (const std::exception& error) {
    throw RunError("the run cannot be recorded", error);
  }
}

void log_warnings(const config::Config& config) {
  for (const auto warnings :
       {config::supervision_warnings, config::stroke_warnings, config::setpoint_warnings})
    for (const std::string& warning : warnings(config)) spdlog::warn(warning);
}

/// Runs the controller with the twin on a simulated bus. The log has virtual times. The files of the real
/// stage stay unchanged: the rehearsal opens no socket, writes no file after a fault (black box), and neither
/// reads nor writes a saved hysteresis memory.
int rehearse(const config::Config& config, const ControllerArguments& options) {
  std::vector<controller::TrackingStatistics> statistics;
  double limit_s = std::max(options.duration_s, patience_s);  // latest end of the rehearsal
  for (const config::AxisConfig& axis : config.axes) {
    statistics.emplace_back(axis.control, settle_s);
    limit_s = std::max(limit_s, patience_s + controller::reference_of(axis.control).length_s());
  }
  std::optional<controller::CsvLog> csv;
  if (!options.csv.empty()) csv.emplace(options.csv, config::axis_names(config));
  const rehearsal::Rehearsal* virtual_time = nullptr;
  const can::BusHealthLog::Sink log_line = [&](can::BusHealthLog::Level level, const std::string& line) {
    bus_log_sink()(level, fmt::format("{:.3f} s: {}", virtual_time->time_s(), line));
  };
  StateLog log(config, log_line);
  rehearsal::Rehearsal rehearsal(rehearsal_setup(config), [&](const controller::CycleRecord& record) {
    statistics[record.axis].add(record.report);
    if (csv) csv->write(record);
    log.add(record);
  });
  virtual_time = &rehearsal;
  rehearsal.twin().faults().on_event([&](const twin::FaultSpec& fault, bool begins, can::Time) {
    log_line(can::BusHealthLog::Level::info,
             fmt::format("twin: {} {}", twin::describe(fault), begins ? "begins" : "ends"));
  });
  spdlog::set_pattern("[%n] [%^%l%$] %v");
  log_warnings(config);

  controller::Controller& controller = rehearsal.controller();
  run_and_stop(rehearsal, limit_s, [&] {
    return is_done(controller, options, rehearsal.time_s(), can::seconds(config.controller.start_timeout));
  });

  const auto lost = csv ? csv->close() : std::nullopt;
  const std::vector<controller::AxisOutcome> outcomes = outcomes_of(controller, statistics);
  spdlog::default_logger()->flush();
  print(results_text(controller, log, outcomes, options, 0));
  require_success(controller, log, options, true, outcomes);
  if (lost) throw RunError(*lost);
  return done;
}

int run_controller(ControllerArguments options) {
  config::ReadFiles files;
  config::Config config = config::load(options.config, {}, files);
  if (options.rehearse && options.duration_s == 0.0) options.once = true;
  if (!options.interface.empty()) config.bus.interface = options.interface;
  if (options.once)
    for (config::AxisConfig& axis : config.axes) axis.control.repeat = false;

  if (!options.record.empty()) config.record.folder = options.record;
  if (!options.record.empty()) config.record.at_start = true;

  refuse_to_overwrite(options.csv, options.config);
  if (options.rehearse) return rehearse(config, options);
  share_heap();
  const SavedStates states(config);

  LiveLoop loop(config.bus.interface);
  std::unique_ptr<controller::TelemetryThread> telemetry;
  controller::Controller controller(controller_config(config), config.database, loop.scheduler(),
                                    loop.attach_controller(),
                                    [&](const controller::CycleRecord& record) { telemetry->push(record); });
  check_interface(config, config.bus.interface);
  states.restore(controller);
  // The recorder replaces the CSV of the previous run. It is created after the bus was opened, so that a
  // failed start keeps the previous CSV.
  CycleRecorder recorder(config, states, options.csv);
  if (config.record.at_start) start_recording(recorder.outlets().recorder);
  telemetry = std::make_unique<controller::TelemetryThread>(
      [&](const controller::CycleRecord& record) { recorder.consume(record); });
  auto control = std::make_unique<ControlService>(options.config, config, std::move(files), socket_of(config),
                                                  recorder.outlets());
  controller.listen_to(control->requests());
  spdlog::info("{} at {} Hz on {}; Ctrl-C ramps down and stops", counted(config.axes.size(), "axis", "axes"),
               config.controller.rate_Hz, config.bus.interface);
  log_warnings(config);
  become_realtime(config);
  const bool was_enabled = run_to_the_end(loop, controller, *control, recorder, options,
                                          can::seconds(config.controller.start_timeout));
  control.reset();

  const std::uint64_t dropped = telemetry->dropped();
  telemetry.reset();
  recorder.outlets().recorder.finish();
  recorder.bus_log().write();
  recorder.black_box().finish();
  states.save(controller);
  const auto lost = recorder.close_csv();
  const std::vector<controller::AxisOutcome> outcomes = outcomes_of(controller, recorder.statistics());
  spdlog::default_logger()->flush();  // prints the last log lines before the results
  const auto unprinted =
      print_patiently(results_text(controller, recorder.log(), outcomes, options, dropped));
  require_success(controller, recorder.log(), options, was_enabled, outcomes);
  for (const auto& reason : {lost, unprinted})
    if (reason) throw RunError(*reason);
  return done;
}

}  // namespace

void add_controller(CLI::App& cli, int& status) {
  auto options = std::make_shared<ControllerArguments>();
  CLI::App* command = cli.add_subcommand("controller", "Control the axes on the bus");
  command->add_option("CONFIG", options->config, "configuration (TOML)")->required();
  CLI::Option* interface = add_checked(*command, "--interface", options->interface, interface_name(),
                                       "CAN interface; default: as configured");
  add_checked(*command, "--duration", options->duration_s, positive_seconds(),
              "duration in seconds; default: until Ctrl-C");
  command->add_flag("--once", options->once, "stop after one pass of the reference");
  CLI::Option* clear = command->add_flag("--clear-faults", options->clear_faults,
                                         "clear a latched fault of the amplifier before the start");
  command->add_option("--csv", options->csv, "CSV file with a row for each cycle");
  CLI::Option* record =
      command->add_option("--record", options->record,
                          "folder for the recording of the whole run, from the start of the program");
  command
      ->add_flag("--rehearse", options->rehearse,
                 "run on the simulated bus, with the twin and its faults, in virtual time; the run ends "
                 "after one pass of the reference, or after --duration")
      ->excludes(interface)
      ->excludes(clear)
      ->excludes(record);
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options, &status] { status = run_controller(*options); });
}

}  // namespace hystcan::app
