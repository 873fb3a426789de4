#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/command_line/commands.h"
#include "app/live/stop_signal.h"
#include "app/stage/config_edit.h"
#include "app/stage/dataset_input.h"
#include "app/stage/dynamics_text.h"
#include "app/stage/identified_plant.h"
#include "app/stage/open_loop.h"
#include "app/stage/option_check.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "can/dbc/text.h"
#include "config/document/toml_text.h"
#include "config/schema/config.h"

namespace hystcan::app {
namespace {

using app::describe;
using app::to_json;

struct DynamicsArguments {
  std::filesystem::path data;
  std::filesystem::path output;
  std::filesystem::path config;  ///< empty: none
  std::filesystem::path written;
  std::string axis;
  std::optional<double> rate_Hz;
  bool cautious = false;
  bool json = false;
  bool all = false;  ///< every design is printed
  config::DatasetLayout layout{};
};

struct IdentifiedDynamics {
  std::string file;  ///< the dataset's file name, without its folder
  std::string input_unit;
  std::string output_unit;
  double rate_Hz = 0.0;  ///< of the loop
  IdentifiedPlant plant;
  controller::Delays stated;         ///< with the identified resonance where there is no configuration
  std::optional<double> sensor_s{};  ///< the configured part of the delay
  std::vector<controller::LoopConfig> designs;  ///< the first one is proposed
  std::vector<controller::JudgedLoop> judged;   ///< of the designs

  const controller::LoopConfig& proposed() const { return designs.front(); }
};

std::string unit_or(const std::string& unit, const char* otherwise) {
  return unit.empty() ? otherwise : unit;
}

/// The delays to start from: those of the configured axis, or an amplifier without lag and a sensor without
/// delay.
controller::Delays configured_delays(const std::optional<config::Config>& config, std::size_t axis) {
  return config ? config->axes[axis].control.delays : controller::Delays{.amplifier_bandwidth_Hz = 1e9};
}

/// No mode is stated: the one that the record shows.
void take_mode(controller::Delays& delays, const identification::Dataset& record) {
  const identification::SecondOrderFit fit = identification::fit_second_order(record);
  delays.resonance_Hz = fit.natural_frequency_Hz.value;
  delays.damping_ratio = fit.damping_ratio.value;
}

/// Designs for a loop whose commands take effect at the next SYNC.
void design(IdentifiedDynamics& identified, bool cautious) {
  const double cycle_s = 1.0 / identified.rate_Hz;
  identified.plant.delays.command_delay = std::chrono::nanoseconds(std::llround(1e9 * cycle_s));
  const controller::SensitivityRule rule;
  const auto corners = controller::widened(identified.plant.uncertainty, rule.resonance_percent);
  controller::LoopConfig plain{.delays = identified.plant.delays, .cycle_s = cycle_s};
  if (cautious) {
    plain.pi = controller::largest_gains(plain, corners, controller::CautiousRule{});
    identified.designs = {plain};
  } else {
    identified.designs = controller::designs(plain, identified.plant.uncertainty, rule);
  }
  for (const controller::LoopConfig& loop : identified.designs)
    identified.judged.push_back(controller::judge(loop, corners));
}

IdentifiedDynamics find(const DynamicsArguments& options, const std::optional<config::Config>& config,
                        std::size_t axis) {
  const identification::Dataset record = load_noting(options.data, options.layout);
  try {
    IdentifiedDynamics identified;
    identified.file = options.data.filename().string();
    identified.input_unit = unit_or(record.input_unit, "input unit");
    identified.output_unit = unit_or(record.output_unit, "output unit");
    controller::Delays configured = configured_delays(config, axis);
    if (config)
      identified.sensor_s = configured.sensor_s();
    else
      take_mode(configured, record);
    identified.plant = identified_plant(record, configured);
    identified.rate_Hz =
        options.rate_Hz.value_or(config ? config->controller.rate_Hz : 1.0 / identified.plant.cycle_s);
    identified.stated = config ? configured : identified.plant.delays;
    design(identified, options.cautious);
    return identified;
  } catch (const identification::ModeNotShown& error) {
    throw Error(
        fmt::format("{}: {}; with --config the stated one is taken", options.data.string(), error.what()));
  } catch (const std::invalid_argument& error) {
    throw Error(fmt::format("{}: {}", options.data.string(), error.what()));
  }
}

std::string filters_of(const controller::LoopConfig& loop) {
  if (loop.notch) return fmt::format(", notch {} (Hz, depth, width)", describe(*loop.notch));
  if (loop.measurement_filter_Hz > 0.0) return fmt::format(", low pass {} Hz", loop.measurement_filter_Hz);
  return ", no filter";
}

std::string delay_shares(const IdentifiedDynamics& identified) {
  if (!identified.sensor_s) return line("", "--config tells the sensor's share, if the configuration has it");
  return line(
      "", fmt::format("sensor {:.4g} ms ([axis.control.delays]); the rest is counted as the amplifier's lag",
                      1e3 * *identified.sensor_s));
}

/// The text for the terminal and for the comment in the fragment, with this many of the designs.
std::string describe(const IdentifiedDynamics& identified, std::size_t shown) {
  const IdentifiedPlant& plant = identified.plant;
  std::string text =
      line("dataset", fmt::format("{}: {} at {:.6g} Hz{}", identified.file, counted(plant.rows, "row"),
                                  1.0 / plant.cycle_s, left_out_text(plant))) +
      describe(plant, identified.stated, identified.input_unit, identified.output_unit) +
      delay_shares(identified);
  for (std::size_t i = 0; i < shown; ++i) {
    const controller::LoopConfig& loop = identified.designs[i];
    const auto& [margins, worst] = identified.judged[i];
    text += line(i == 0 ? "PI gains" : "less fast",
                 fmt::format("kp {:.5g} um per um, ki {:.5g} 1/s, at {:.6g} Hz{}", loop.pi.kp,
                             loop.pi.ki_per_s, identified.rate_Hz, filters_of(loop))) +
            line("loop", describe(margins)) +
            line("at the worst", describe(worst) + " (corners of the intervals)") +
            line("speed", fmt::format("crossover {:.4g} Hz, bandwidth of the feedback alone {:.4g} Hz",
                                      margins.crossover_Hz, margins.bandwidth_Hz));
  }
  if (const std::size_t more = identified.designs.size() - shown; more > 0)
    text += line("", fmt::format("--all shows {} that {} still less fast", counted(more, "design"),
                                 more == 1 ? "is" : "are"));
  return text;
}

std::string rule_text(bool cautious) {
  return cautious ? describe(controller::CautiousRule{}) : describe(controller::SensitivityRule{});
}

std::string fragment(const IdentifiedDynamics& identified, const controller::Delays& configured,
                     const config::AxisConfig* axis, const std::string& comment) {
  const controller::Delays& found = identified.plant.delays;
  config::AxisConfig before, after;
  if (axis != nullptr) before.control = axis->control;
  before.control.delays = configured;
  after = before;
  set_loop(after.control, identified.proposed());
  std::map<std::string, std::string> notes{{"axis.control.kp", " um per um"},
                                           {"axis.control.ki_per_s", ""},
                                           {"axis.control.delays.resonance_Hz", ""},
                                           {"axis.control.delays.damping_ratio", ""}};
  if (found.amplifier_bandwidth_Hz != configured.amplifier_bandwidth_Hz)
    notes["axis.control.delays.amplifier_bandwidth_Hz"] =
        fmt::format("; {:.4g} ms of lag", 1e3 * found.lag_s());
  if (found.sensor_delay != configured.sensor_delay)
    notes["axis.control.delays.sensor_delay_us"] = "; a pure delay beside the lag";
  return "# Second-order dynamics of one axis: these keys replace those of its [axis.control].\n#\n" +
         config::toml_comment(can::dbc::to_utf8(comment)) +
         control_fragment(before, axis != nullptr, after, notes);
}

nlohmann::json to_json(const IdentifiedDynamics& identified) {
  nlohmann::json json = to_json(identified.plant);
  const controller::LoopConfig& loop = identified.proposed();
  json["rate_Hz"] = identified.rate_Hz;
  json["kp"] = loop.pi.kp;
  json["ki_per_s"] = loop.pi.ki_per_s;
  json["measurement_filter_Hz"] = loop.measurement_filter_Hz;
  json["notch"] = to_json(loop.notch);
  json["amplifier_bandwidth_Hz"] = identified.plant.delays.amplifier_bandwidth_Hz;
  json["sensor_delay_us"] = microseconds(identified.plant.delays.sensor_delay);
  json["margins"] = to_json(identified.judged.front().margins);
  json["worst_margins"] = to_json(identified.judged.front().worst);
  return json;
}

/// The configuration with the result in it, if it was asked for.
void write_config(const DynamicsArguments& options, const config::Config& config, std::size_t axis,
                  const IdentifiedDynamics& identified) {
  OutputFile out(options.written);
  out.write(with_loop(config, axis, identified.proposed()));
  out.commit();
}

int dynamics(const DynamicsArguments& options) {
  refuse_to_overwrite(options.output, options.data);
  std::optional<config::Config> config;
  std::size_t axis = 0;
  if (!options.config.empty()) {
    config = config::load(options.config);
    axis = index_of_axis(*config, options.axis);
    refuse_to_overwrite_inputs(options.output, options.config, *config);
    if (!options.written.empty())
      refuse_to_write_into(options.written, *config, options.output, options.data);
  }
  const IdentifiedDynamics identified = find(options, config, axis);
  stop_at_a_signal();  // no unfinished file remains
  const std::size_t shown =
      options.all ? identified.designs.size() : std::min<std::size_t>(2, identified.designs.size());
  const std::string text = describe(identified, shown) + rule_text(options.cautious);
  OutputFile out(options.output);
  out.write(
      fragment(identified, configured_delays(config, axis), config ? &config->axes[axis] : nullptr, text));
  if (!options.written.empty()) write_config(options, *config, axis, identified);
  out.commit();
  print("{}", options.json ? to_json(identified).dump(2) + "\n" : text);
  return done;
}

}  // namespace

void add_dynamics(CLI::App& cli, int& status) {
  auto options = std::make_shared<DynamicsArguments>();
  CLI::App* command = cli.add_subcommand(
      "dynamics",
      "Identify natural frequency, damping and delay from a small step or chirp; compute PI gains");
  command
      ->add_option("DATA", options->data,
                   "CSV: time_s,input,output, evenly sampled; the input is the drive in force from a row's "
                   "time until the next row's")
      ->required();
  command->add_option("--output", options->output, "fragment of a configuration to write (TOML)")->required();
  command
      ->add_option("--rate", options->rate_Hz,
                   "rate of the controller, Hz (default: the configuration's, or the dataset's)")
      ->check(positive_number());
  CLI::Option* with_config =
      command->add_option("--config", options->config,
                          "configuration (TOML): its sensor's delay, its rate, and what --write starts from");
  command->add_option("--axis", options->axis, "name of its axis; the first one if left out")
      ->needs(with_config);
  command
      ->add_option("--write", options->written, "copy of the configuration to write, with the result in it")
      ->needs(with_config);
  add_column_options(*command, options->layout);
  command->add_flag("--cautious", options->cautious,
                    "the rule that counts no phase beyond -180 degrees; stays stable with any delay");
  command->add_flag("--all", options->all, "print every design, not the two fastest alone");
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options, &status] { status = dynamics(*options); });
}

}  // namespace hystcan::app
