#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/command_line/commands.h"
#include "app/command_line/demo_page.h"
#include "app/command_line/truth_log.h"
#include "app/live/rehearsal_setup.h"
#include "app/live/report.h"
#include "app/live/stop_signal.h"
#include "app/stage/pictures.h"
#include "app/stage/promise.h"
#include "app/stage/shipped.h"
#include "app/stage/tuning.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "config/schema/config.h"
#include "controller/telemetry.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {
namespace {

struct DemoArguments {
  std::filesystem::path config;
  std::filesystem::path output = "hystcan-demo";
  bool json = false;
  bool all = false;
  std::string page;  ///< listening address of the operator's page; empty: no page
};

struct Column {
  controller::Structure structure;
  rehearsal::Outcome outcome;
  std::string failure;  ///< reason of the failure; empty if every axis tracked without a fault
};

/// Runs one controller structure and writes its two CSV files: the log of the controller and the true states
/// of the twin. Removes both files if the run is stopped.
Column run_column(const rehearsal::Setup& setup, controller::Structure structure,
                  const std::vector<std::string>& axis_names, const std::filesystem::path& directory) {
  const auto log_file = directory / fmt::format("{}.csv", to_string(structure));
  const auto truth_file = directory / fmt::format("{}.truth.csv", to_string(structure));
  try {
    controller::CsvLog csv(log_file, axis_names);
    TruthLog truth(truth_file, axis_names);
    rehearsal::Outcome outcome = rehearsal::run_once(
        with_structure(setup, structure), settle_s,
        [&](const auto& record) {
          if (stop_signalled != 0) throw RunError("stopped before the end of the comparison");
          csv.write(record);
        },
        [&](const auto& sampled) { truth.write(sampled); });
    for (const auto& lost : {csv.close(), truth.close()})
      if (lost) throw RunError(*lost);
    std::string failure = failure_of(outcome.axes);
    return {structure, std::move(outcome), std::move(failure)};
  } catch (const std::exception&) {
    for (const auto& file : {log_file, truth_file}) std::filesystem::remove(file);
    throw;
  }
}

/// Returns the two controller structures that the demo compares. The first is `average`, which has no
/// feedback (open loop). The second is the configured structure, or `inverse+pi` if the configured structure
/// is `average`.
std::vector<controller::Structure> open_and_closed_loop(const config::Config& config) {
  using enum controller::Structure;
  const controller::Structure configured = config.axes.front().control.law.structure;
  return {average, configured == average ? inverse_pi : configured};
}

/// Runs each controller structure. If one fails, prints the failure and continues with the next structure.
std::vector<Column> run_columns(const config::Config& config,
                                std::span<const controller::Structure> structures,
                                const std::filesystem::path& directory) {
  const rehearsal::Setup setup = rehearsal_setup(config);
  const std::vector<std::string> names = config::axis_names(config);
  std::vector<Column> columns;
  for (const controller::Structure structure : structures) {
    columns.push_back(run_column(setup, structure, names, directory));
    if (const std::string& failure = columns.back().failure; !failure.empty())
      note("hystcan: {}: {}\n", to_string(structure), failure);
  }
  return columns;
}

double preview_ms(const config::Config& config) {
  const controller::AxisConfig& control = config.axes.front().control;
  const double cycle_s = 1.0 / config.controller.rate_Hz;
  return 1e3 * controller::chain_moments(control.delays, control.law.notch, cycle_s).mean_s;
}

std::vector<std::optional<double>> floors_um(const config::Config& config) {
  const config::AxisConfig& axis = config.axes.front();
  return tracking_floors_um(axis.twin, axis.control.setpoint, 1.0 / config.controller.rate_Hz);
}

std::string error_cells(const controller::ErrorStatistics& error, double stroke_um) {
  return fmt::format("{:>9.4f} {:>7.3f} {:>9.4f} {:>7.3f}", error.rms_um(),
                     100.0 * error.rms_um() / stroke_um, error.max_um, 100.0 * error.max_um / stroke_um);
}

void print_heading(const config::Config& config, double stroke_um) {
  const config::AxisConfig& axis = config.axes.front();
  const twin::Plant::Config& plant = axis.twin.plant;
  print(
      "{}, axis {}: sample rate {:g} Hz, command delay {:g} ms, preview {:.3f} ms, resonance {:g} Hz, "
      "damping {:g}, stroke {:g} um\n",
      config.file.filename().string(), axis.wire.name, config.controller.rate_Hz,
      std::chrono::duration<double, std::milli>(axis.control.delays.command_delay).count(),
      preview_ms(config), plant.mode.natural_frequency_Hz, plant.mode.damping_ratio, stroke_um);
  print(
      "at the samples: reference - measured; true: reference - position of the twin, every {:g} us\n"
      "floor: the smallest true RMS error of any sequence of setpoints; the amplifier {} one setpoint "
      "per cycle\n"
      "the twin's actuator differs from the controller's model ({} against {})\n\n",
      1e6 * can::seconds(plant.substep), axis.twin.interpolate ? "interpolates" : "holds",
      axis.twin_model.string(), axis.control_model.string());
  print("{:<12} {:<15}  {:^35}  {:^35}  {:>9}\n{:<12} {:<15}", "", "", "at the samples", "true", "floor",
        "structure", "segment");
  for (int i = 0; i < 2; ++i)
    print("  {:>9} {:>7} {:>9} {:>7}", "RMS [um]", "RMS [%]", "max [um]", "max [%]");
  print("  {:>9}\n", "RMS [%]");
}

void print_column(const config::Config& config, const Column& column,
                  const std::vector<std::optional<double>>& floors) {
  if (!column.failure.empty()) {
    print("{:<12} failed: {}\n", to_string(column.structure), column.failure);
    return;
  }
  const controller::AxisOutcome& outcome = column.outcome.axes.front();
  const controller::TrackingStatistics& truth = column.outcome.true_errors.front();
  const double stroke_um = outcome.stroke_um;
  print("{:<12} {:<15}  {}  {}\n", to_string(column.structure), "whole reference",
        error_cells(outcome.statistics.total(), stroke_um), error_cells(truth.total(), stroke_um));
  for (std::size_t i = 0; i < floors.size(); ++i)
    print("{:<12} {:<15}  {}  {}{}\n", "", to_string(config.axes.front().control.setpoint[i].shape),
          error_cells(outcome.statistics.segments()[i], stroke_um),
          error_cells(truth.segments()[i], stroke_um),
          floors[i] ? fmt::format("  {:>9.3f}", 100.0 * *floors[i] / stroke_um) : "");
}

void print_table(const config::Config& config, const std::vector<Column>& columns,
                 const std::vector<Promise>& promises) {
  print_heading(config, columns.front().outcome.axes.front().stroke_um);
  const auto floors = floors_um(config);
  for (const Column& column : columns) print_column(config, column, floors);
  print("\n");
  const controller::Structure configured = config.axes.front().control.law.structure;
  for (const Column& column : columns)
    if (column.structure == configured && column.failure.empty())
      for (const controller::AxisOutcome& outcome : column.outcome.axes)
        for (const std::string& line : describe_segments(outcome))
          print("{}: {}\n", to_string(configured), line);
  for (const Promise& promise : promises) print("{}\n", text_of(promise));
}

/// Prints how many times smaller the RMS of the true error is in the last column, the configured controller
/// structure, than in the first column, the open loop (`average`). The true error is the error of the
/// simulated stage, without sensor errors.
void print_gain(const std::vector<Column>& columns) {
  const Column &open = columns.front(), &closed = columns.back();
  if (!open.failure.empty() || !closed.failure.empty()) return;
  const double open_um = open.outcome.true_errors.front().total().rms_um();
  const double closed_um = closed.outcome.true_errors.front().total().rms_um();
  print("true RMS error: {:.4g} um in open loop ({}), {:.4g} um with {}: {:.3g} times smaller\n", open_um,
        to_string(open.structure), closed_um, to_string(closed.structure), open_um / closed_um);
}

void print_comparison_json(const config::Config& config, const std::vector<Column>& columns,
                           const std::vector<Promise>& promises, double cycles_per_s) {
  const config::AxisConfig& axis = config.axes.front();
  nlohmann::json json{{"config", config.file.string()},
                      {"axis", axis.wire.name},
                      {"rate_hz", config.controller.rate_Hz},
                      {"preview_ms", preview_ms(config)},
                      {"resonance_hz", axis.twin.plant.mode.natural_frequency_Hz},
                      {"damping_ratio", axis.twin.plant.mode.damping_ratio},
                      {"axis_cycles_per_s", cycles_per_s},
                      {"floors_um", nlohmann::json::array()},
                      {"promise", promises.empty() ? nlohmann::json() : to_json(promises.front())},
                      {"columns", nlohmann::json::array()}};
  for (const std::optional<double>& floor_um : floors_um(config))
    json["floors_um"].push_back(floor_um ? nlohmann::json(*floor_um) : nlohmann::json());
  for (const Column& column : columns) {
    nlohmann::json entry = to_json(column.outcome.axes.front());
    entry["structure"] = to_string(column.structure);
    entry["failure"] = column.failure;
    entry["true"] = to_json(column.outcome.true_errors.front(), column.outcome.axes.front().stroke_um);
    json["columns"].push_back(entry);
  }
  print("{}\n", json.dump(2));
}

int run_demo(const DemoArguments& options) {
  if (!options.page.empty()) return run_demo_page(options.config, options.page);
  const config::Config config =
      config::load(options.config.empty() ? shipped_file("piezo.toml") : options.config);
  create_folder(options.output);
  stop_at_a_signal();
  const auto start = std::chrono::steady_clock::now();
  const std::vector<controller::Structure> structures =
      options.all ? std::vector(controller::all_structures.begin(), controller::all_structures.end())
                  : open_and_closed_loop(config);
  const std::vector<Column> columns = run_columns(config, structures, options.output);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;

  double axis_cycles = 0.0;
  double virtual_s = 0.0;
  for (const Column& column : columns) {
    axis_cycles += static_cast<double>(column.outcome.counters.cycles * config.axes.size());
    virtual_s += column.outcome.virtual_s;
  }
  const std::vector<Promise> promises = promises_of(config);
  if (options.json)
    print_comparison_json(config, columns, promises, axis_cycles / wall.count());
  else
    print_table(config, columns, promises);
  if (!options.json && !options.all) print_gain(columns);

  const config::AxisConfig& axis = config.axes.front();
  const double tracking_s =
      columns.front().outcome.virtual_s - controller::reference_of(axis.control).length_s();
  const double rate_Hz = config.controller.rate_Hz;
  const double begin_s = tracking_s + axis.control.setpoint.front().transition_s;
  std::vector<std::string> names, files;
  // With --all, the structure `inverse` is not drawn, because its curve would cover the curves of the other
  // structures.
  for (const controller::Structure structure : structures)
    if (structure != controller::Structure::inverse || !options.all) {
      names.emplace_back(to_string(structure));
      files.push_back(names.back() + ".csv");
    }
  const auto undrawn =
      draw_pictures(options.output / "pictures.json",
                    {{.kind = "demo",
                      .data = files,
                      .to = {"demo.svg", "demo.png"},
                      .size = {.width_mm = 240.0, .height_mm = 190.0},
                      .facts = {{"title", config.file.stem().string() + ", axis " + axis.wire.name},
                                {"axis", axis.wire.name},
                                {"names", names},
                                {"drive_unit", axis.wire.drive_unit},
                                {"stroke_um", columns.front().outcome.axes.front().stroke_um},
                                {"delay_cycles", rate_Hz * axis.control.delays.to_sample_s(1.0 / rate_Hz)},
                                {"from_s", begin_s},
                                {"to_s", begin_s + 0.3}}}});
  note("{:.1f} s of virtual time in {:.2f} s, {:.0f} axis-cycles per second (CSV files included)\n",
       virtual_s, wall.count(), axis_cycles / wall.count());
  note("{}: {}\n", options.output.string(),
       undrawn ? "two CSV files for each control structure (log of the controller, true states of the twin); "
                 "no picture: " +
                     *undrawn
               : "demo.svg, demo.png, and two CSV files for each control structure "
                 "(log of the controller, true states of the twin)");
  const bool failed_once =
      std::ranges::any_of(columns, [](const Column& column) { return !column.failure.empty(); });
  return failed_once ? failed : done;
}

}  // namespace

void add_demo(CLI::App& cli, int& status) {
  auto options = std::make_shared<DemoArguments>();
  CLI::App* command = cli.add_subcommand(
      "demo", "Run controller and twin on a simulated bus; compare open loop and closed loop");
  command->add_option("--config", options->config, "configuration (TOML); default: the shipped piezo stage");
  command->add_option("--output", options->output, "folder for CSV and plot")->capture_default_str();
  command->add_flag("--all", options->all, "compare all five control structures");
  command->add_flag("--json", options->json, "print the table as JSON");
  command
      ->add_option(
          "--page", options->page,
          "compare nothing, run in real time until Ctrl-C, and serve the operator's page at this address")
      ->expected(0, 1)
      ->default_str("127.0.0.1:8080");
  command->callback([options, &status] { status = run_demo(*options); });
}

}  // namespace hystcan::app
