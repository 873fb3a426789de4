#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "app/commands/commands.h"
#include "app/io/option_check.h"
#include "app/io/output_file.h"
#include "app/live/stop_signal.h"
#include "app/report/dynamics_text.h"
#include "can/counted.h"
#include "config/files/dataset_file.h"
#include "config/schema/config.h"

namespace hystcan::app {
namespace {

using app::describe;
using app::to_json;
using identification::SecondOrderFit;

struct DynamicsArguments {
  std::filesystem::path data;
  std::filesystem::path output;
  std::optional<double> rate_Hz;
  bool json = false;
};

struct IdentifiedDynamics {
  std::string file;  ///< the dataset's file name, without its folder
  std::string input_unit;
  std::string output_unit;
  SecondOrderFit fit;
  double rate_Hz = 0.0;  ///< of the loop
  controller::JudgedLoop loop;
};

std::string unit_or(const std::string& unit, const char* otherwise) {
  return unit.empty() ? otherwise : unit;
}

/// The gains of the cautious rule in a loop whose commands take effect at the next SYNC.
controller::JudgedLoop designed(const SecondOrderFit& fit, double cycle_s) {
  const IdentifiedPlant plant =
      plant_of(fit, {.command_delay = std::chrono::nanoseconds(std::llround(1e9 * cycle_s)),
                     .amplifier_bandwidth_Hz = 1e9});
  const controller::LoopConfig loop{.delays = plant.delays, .cycle_s = cycle_s};
  return controller::judge(loop, plant.uncertainty,
                           controller::largest_gains(loop, controller::CautiousRule{}));
}

IdentifiedDynamics find(const DynamicsArguments& options) {
  const config::DatasetFile file = config::load_dataset(options.data);
  try {
    IdentifiedDynamics identified;
    identified.file = options.data.filename().string();
    identified.input_unit = unit_or(file.dataset.input_unit, "input unit");
    identified.output_unit = unit_or(file.dataset.output_unit, "output unit");
    identified.fit = identification::fit_second_order(file.dataset);
    identified.rate_Hz = options.rate_Hz.value_or(1.0 / identified.fit.cycle_s);
    identified.loop = designed(identified.fit, 1.0 / identified.rate_Hz);
    return identified;
  } catch (const std::invalid_argument& error) {
    throw config::Error(fmt::format("{}: {}", options.data.string(), error.what()));
  }
}

/// The text for the terminal and for the comment in the fragment.
std::string describe(const IdentifiedDynamics& identified) {
  const SecondOrderFit& fit = identified.fit;
  const controller::JudgedLoop& loop = identified.loop;
  return line("dataset", fmt::format("{}: {} at {:.6g} Hz", identified.file, can::counted(fit.rows, "row"),
                                     1.0 / fit.cycle_s)) +
         describe(fit, identified.input_unit, identified.output_unit) +
         line("PI gains", fmt::format("kp {} um per um, ki {} 1/s, at {:.6g} Hz", loop.pi.kp,
                                      loop.pi.ki_per_s, identified.rate_Hz)) +
         line("loop", describe(loop.margins)) +
         line("at the worst", describe(loop.worst) + " (corners of the intervals)") +
         line("speed", fmt::format("crossover {:.4g} Hz, bandwidth of the feedback alone {:.4g} Hz",
                                   loop.margins.crossover_Hz, loop.margins.bandwidth_Hz)) +
         describe(controller::CautiousRule{});
}

std::string delay_key(const identification::Estimate& delay_s) {
  const auto bandwidth_Hz = bandwidth_Hz_for(delay_s);
  if (!bandwidth_Hz)
    return "# amplifier_bandwidth_Hz: unchanged, the delay cannot be distinguished from zero\n";
  return fmt::format(
      "amplifier_bandwidth_Hz = {}   # represents the identified delay: {:.4g} ms = 1 / (2 pi bandwidth)\n",
      toml_number(*bandwidth_Hz), 1e3 * delay_s.value);
}

std::string fragment(const IdentifiedDynamics& identified) {
  return "# Second-order dynamics of one axis: these keys replace those of its [axis.control].\n#\n" +
         as_comment(describe(identified)) +
         fmt::format("\n[axis.control]\nkp       = {}   # um per um\nki_per_s = {}\n",
                     toml_number(identified.loop.pi.kp), toml_number(identified.loop.pi.ki_per_s)) +
         "\n[axis.control.delays]\n" + delay_key(identified.fit.delay_s) +
         fmt::format("resonance_Hz  = {}\ndamping_ratio = {}\n",
                     toml_number(rounded(identified.fit.natural_frequency_Hz.value)),
                     toml_number(rounded(identified.fit.damping_ratio.value)));
}

nlohmann::json to_json(const IdentifiedDynamics& identified) {
  nlohmann::json json = to_json(identified.fit);
  json["rate_Hz"] = identified.rate_Hz;
  json["kp"] = identified.loop.pi.kp;
  json["ki_per_s"] = identified.loop.pi.ki_per_s;
  json["margins"] = to_json(identified.loop.margins);
  json["worst_margins"] = to_json(identified.loop.worst);
  return json;
}

int dynamics(const DynamicsArguments& options) {
  refuse_to_overwrite(options.output, options.data);
  const IdentifiedDynamics identified = find(options);
  stop_at_a_signal();  // no unfinished file remains
  OutputFile out(options.output);
  out.write(fragment(identified));
  out.commit();
  fmt::print("{}", options.json ? to_json(identified).dump(2) + "\n" : describe(identified));
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
  command->add_option("--rate", options->rate_Hz, "rate of the controller, Hz (default: the dataset's)")
      ->check(positive_number());
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options, &status] { status = dynamics(*options); });
}

}  // namespace hystcan::app
