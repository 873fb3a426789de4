#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "app/commands.h"
#include "app/dynamics_text.h"
#include "app/output_file.h"
#include "config/config.h"
#include "config/record_file.h"
#include "identification/tuning.h"

namespace hystcan::app {
namespace {

using app::describe;
using app::to_json;
using identification::SecondOrderFit;
using identification::Tuning;

struct Options {
  std::filesystem::path data;
  std::filesystem::path output;
  std::optional<double> rate_Hz;
  bool json = false;
};

struct Found {
  std::string file;  ///< the record's name, without its folder
  std::string input_unit;
  std::string output_unit;
  SecondOrderFit fit;
  double rate_Hz = 0.0;  ///< of the loop
  Tuning tuning;
};

std::string unit_or(const std::string& unit, const char* otherwise) {
  return unit.empty() ? otherwise : unit;
}

Found find(const Options& options) {
  const config::RecordFile file = config::load_record(options.data);
  try {
    Found found;
    found.file = options.data.filename().string();
    found.input_unit = unit_or(file.record.input_unit, "input unit");
    found.output_unit = unit_or(file.record.output_unit, "output unit");
    found.fit = identification::fit_second_order(file.record);
    found.rate_Hz = options.rate_Hz.value_or(1.0 / found.fit.cycle_s);
    found.tuning = identification::tune(found.fit, 1.0 / found.rate_Hz);
    return found;
  } catch (const std::invalid_argument& error) {
    throw config::Error(fmt::format("{}: {}", options.data.string(), error.what()));
  }
}

/// What both the reader of the terminal and the reader of the fragment are told.
std::string describe(const Found& found) {
  const SecondOrderFit& fit = found.fit;
  const Tuning& tuning = found.tuning;
  return line("record", fmt::format("{}: {} rows at {:.6g} Hz", found.file, fit.rows, 1.0 / fit.cycle_s)) +
         describe(fit, found.input_unit, found.output_unit) +
         line("PI gains", fmt::format("kp {} um per um, ki {} 1/s, at {:.6g} Hz", tuning.gains.kp,
                                      tuning.gains.ki_per_s, found.rate_Hz)) +
         line("loop", describe(tuning.margins)) +
         line("at the worst", describe(tuning.worst) + " (corners of the intervals)") +
         line("speed", fmt::format("crossover {:.4g} Hz, bandwidth of the feedback alone {:.4g} Hz",
                                   tuning.margins.crossover_Hz, tuning.margins.bandwidth_Hz)) +
         describe(identification::PiRule{});
}

std::string delay_key(const identification::Estimate& delay_s) {
  const auto bandwidth_Hz = bandwidth_Hz_for(delay_s);
  if (!bandwidth_Hz) return "# amplifier_bandwidth_Hz: as it is, no delay can be told from none\n";
  return fmt::format(
      "amplifier_bandwidth_Hz = {}   # stands for the delay found: {:.4g} ms = 1 / (2 pi bandwidth)\n",
      toml_number(*bandwidth_Hz), 1e3 * delay_s.value);
}

std::string fragment(const Found& found) {
  return "# Second-order dynamics of one axis: these keys replace those of its [axis.control].\n#\n" +
         as_comment(describe(found)) +
         fmt::format("\n[axis.control]\nkp       = {}   # um per um\nki_per_s = {}\n",
                     toml_number(found.tuning.gains.kp), toml_number(found.tuning.gains.ki_per_s)) +
         "\n[axis.control.delays]\n" + delay_key(found.fit.delay_s) +
         fmt::format("resonance_Hz  = {}\ndamping_ratio = {}\n",
                     toml_number(rounded(found.fit.natural_frequency_Hz.value)),
                     toml_number(rounded(found.fit.damping_ratio.value)));
}

nlohmann::json to_json(const Found& found) {
  nlohmann::json json = to_json(found.fit);
  json["rate_Hz"] = found.rate_Hz;
  json["kp"] = found.tuning.gains.kp;
  json["ki_per_s"] = found.tuning.gains.ki_per_s;
  json["margins"] = to_json(found.tuning.margins);
  json["worst_margins"] = to_json(found.tuning.worst);
  return json;
}

int dynamics(const Options& options) {
  refuse_to_overwrite(options.output, options.data);
  if (options.rate_Hz && !(*options.rate_Hz > 0.0 && std::isfinite(*options.rate_Hz)))
    throw config::Error(fmt::format("--rate is {}, expected a positive number", *options.rate_Hz));
  const Found found = find(options);
  OutputFile out(options.output);
  out.write(fragment(found));
  out.commit();
  fmt::print("{}", options.json ? to_json(found).dump(2) + "\n" : describe(found));
  return done;
}

}  // namespace

void add_dynamics(CLI::App& cli, int& status) {
  auto options = std::make_shared<Options>();
  CLI::App* command = cli.add_subcommand(
      "dynamics", "Natural frequency, damping and delay from a small step or chirp; PI gains from these");
  command
      ->add_option("DATA", options->data,
                   "CSV: time_s,input,output, evenly sampled; the input is the drive in force from a row's "
                   "time until the next row's")
      ->required();
  command->add_option("--output", options->output, "fragment of a configuration to write (TOML)")->required();
  command->add_option("--rate", options->rate_Hz, "of the controller, Hz (default: the record's)");
  command->add_flag("--json", options->json, "print the result as JSON");
  command->callback([options, &status] { status = dynamics(*options); });
}

}  // namespace hystcan::app
