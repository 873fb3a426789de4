#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "app/command_line/commands.h"
#include "app/live/stop_signal.h"
#include "app/stage/dataset_input.h"
#include "app/stage/new_folder.h"
#include "app/stage/option_check.h"
#include "app/stage/stage_folder.h"
#include "app/stage/stage_questions.h"
#include "base/error.h"
#include "base/standard_streams.h"

namespace hystcan::app {
namespace {

/// Assigns the record files of the options to axes. A single axis gets all --record files; with several axes,
/// each axis gets one file of each option. Throws Error if the numbers of files and axes do not match.
std::vector<AxisRecords> records_by_axis(const InitOptions& options) {
  const std::size_t axes = options.axes.size();
  const auto require_one_each = [&](const char* option, const std::vector<std::filesystem::path>& files) {
    if (files.empty() || files.size() == axes ||
        (axes == 1 && files.size() > 1 && option == std::string("--record")))
      return;
    throw Error(fmt::format("{} is given {} times", option, files.size()),
                expect("one file for each of {} axes", axes));
  };
  require_one_each("--record", options.records);
  if (options.records.size() > 1 && !options.input.layout.output_from.empty())
    throw Error(fmt::format("--output-from is {}", options.input.layout.output_from.string()),
                expect("one --record, not {}", options.records.size()));
  require_one_each("--step", options.steps);
  require_one_each("--unseen", options.unseen);
  if (options.records.empty()) {
    if (!options.steps.empty() || !options.unseen.empty())
      throw Error("--step and --unseen need --record, from which the model is identified");
    return {};
  }
  std::vector<AxisRecords> records(axes);
  for (std::size_t i = 0; i < axes; ++i) {
    if (axes == 1)
      records[i].loop_files = options.records;
    else
      records[i].loop_files = {options.records[i]};
    if (!options.steps.empty()) records[i].step_file = options.steps[i];
    if (!options.unseen.empty()) records[i].unseen_file = options.unseen[i];
    options.model.apply_to(records[i].model);
  }
  return records;
}

int new_stage(const InitOptions& options) {
  require_new(options.folder);
  std::vector<AxisRecords> records = records_by_axis(options);
  for (AxisRecords& of_axis : records) load(of_axis, options.input, options.accept);
  Questions questions(std::cin, !options.yes && isatty(STDIN_FILENO) != 0);
  const StageFacts stage = ask_about(options, records, questions);
  stop_at_a_signal();
  make_stage(options.folder, stage, records);
  return done;
}

int init(const InitOptions& options) {
  if (!options.preset.empty()) {
    copy_preset(options.preset, options.folder);
    return done;
  }
  if (options.carry_on) {
    stop_at_a_signal();
    continue_stage(options.folder, options.model, options.accept);
    return done;
  }
  return new_stage(options);
}

void add_facts(CLI::App& command, InitOptions& facts) {
  command.add_option("--axis", facts.axes, "name of an axis; repeat it for each axis")
      ->default_str("x")
      ->allow_extra_args(false);
  command.add_option(
      "--card", facts.card,
      "can (default): amplifier and sensor are nodes on CAN. Otherwise the name of an analogue card: "
      "comedi:/dev/comedi0, iio:ad5791, simulated");
  add_checked(command, "--unit", facts.drive_unit, one_of({"V", "A"}), "unit of the drive: V or A");
  const auto number = [&](const char* name, std::vector<double>& values, const char* what) {
    add_checked(command, name, values, finite_number(), what)->allow_extra_args(false);
  };
  number("--drive-min", facts.drive_min, "lowest drive; once for all axes, or once for each axis");
  number("--drive-max", facts.drive_max, "highest drive");
  number("--safe", facts.safe_drive, "drive at the end of every run; default: the drive nearest to 0");
  number("--stroke", facts.stroke_um,
         "stroke from the lowest to the highest drive, um; default: from the record");
  number("--sensor-at-safe", facts.sensor_at_safe_um,
         "sensor reading at the safe drive, um; default: from the record, or 0 without a record");
  number("--resonance", facts.resonance_Hz, "first resonance, Hz; default: from the step record");
  number("--damping", facts.damping_ratio,
         "damping ratio of the resonance; default: from the step record, or 0.02 without one");
  number("--sensor-delay", facts.sensor_delay_us,
         "delay of the sensor, from a position to the sample that shows it, us (0: unknown)");
  number("--volts-per-drive", facts.volts_per_drive,
         "card volts per drive unit (0.1: an amplifier of 10 V/V)");
  number("--um-per-V", facts.um_per_V,
         "scale of an analogue sensor, um per V; default: the value of --output-scale");
  add_checked(command, "--interface", facts.interface, interface_name(), "CAN interface (vcan0)");
  command.add_option("--dbc", facts.dbc, "DBC with your own frames; default: the standard frames");
  const auto role = [&](const char* name, const char* key, const char* what) {
    command.add_option(name, facts.roles[key], what)->type_name("MSG.SIG")->allow_extra_args(false);
  };
  role("--setpoint", "command.setpoint",
       "signal of your DBC that commands the drive; once for all axes, or once for each axis");
  role("--position", "sample.position", "signal with the measured position");
  role("--enable", "command.enable", "signal that enables the amplifier, or none");
  command
      .add_option("--role", facts.further_roles,
                  "role (use of a signal) and signal of your DBC, such as status.state=MSG.SIG; repeat the "
                  "option for each role")
      ->allow_extra_args(false);
  add_checked(command, "--nodes", facts.nodes, whole_number(1, 127),
              "two node ids for each axis, amplifier and sensor: 1,2")
      ->delimiter(',');
}

}  // namespace

void add_init(CLI::App& cli, int& status) {
  auto options = std::make_shared<InitOptions>();
  CLI::App* command = cli.add_subcommand(
      "init",
      "Create the folder of a new stage: write configuration and models, then tune and rehearse the loop");
  command->add_option("DIR", options->folder, "folder to create; no file in it is overwritten")->required();
  command
      ->add_option("--record", options->records,
                   "slow loops (CSV) for the hysteresis; repeat the option for each axis, "
                   "or for each rate of a single axis")
      ->allow_extra_args(false);
  command
      ->add_option("--step", options->steps,
                   "small fast steps or a chirp (CSV) for the dynamics; repeat it for each axis")
      ->allow_extra_args(false);
  command
      ->add_option("--unseen", options->unseen, "loops (CSV) that are not in --record, to validate the model")
      ->allow_extra_args(false);
  add_facts(*command, *options);
  add_checked(*command, "--cycle-rate", options->rate_Hz, number_between(1.0, 10'000.0),
              "control rate, Hz (1000)");
  add_column_options(*command, options->input.layout);
  add_checked(*command, "--rate", options->input.layout.rate_Hz, positive_number(),
              "sampling rate of the records, Hz, if they contain no times or only sample numbers");
  add_model_options(*command, options->model);
  command->add_flag("--yes", options->yes, "use the defaults instead of questions");
  command->add_flag(
      "--accept", options->accept,
      "use doubtful records: drop-outs and glitches are removed, and rows with the sensor at the end of "
      "its range are kept");
  CLI::Option* carry_on =
      command->add_flag("--continue", options->carry_on,
                        "continue with the records of `hystcan excite` in DIR and the earlier answers");
  command->add_option("--from", options->preset, "shipped configuration to copy with all its files: piezo")
      ->excludes(carry_on);
  command->callback([options, &status] {
    if (options->axes.empty()) options->axes = {"x"};
    for (const std::string& role : options->further_roles) add_role(options->roles, role);
    status = init(*options);
  });
}

}  // namespace hystcan::app
