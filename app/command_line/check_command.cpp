#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>

#include "app/command_line/commands.h"
#include "app/stage/shipped.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "config/files/model_file.h"
#include "config/schema/bus_plan.h"
#include "config/schema/check.h"
#include "config/schema/config.h"
#include "config/schema/frames.h"
#include "config/schema/setpoint_warnings.h"
#include "config/schema/wiring.h"
#include "model/validity.h"

namespace hystcan::app {
namespace {

/// Prints the present value and the valid range of the model parameters k_ascending and k_descending, one
/// line for each. A range is valid while the other parameter keeps its value. For each value in the range,
/// every branch of the hysteresis model increases. `of` is the name of the model.
void print_limits(const std::string& of, const model::HysteresisParameters& p) {
  using Limit = std::tuple<const char*, model::Direction, double, const char*>;
  for (const auto& [name, direction, k, other] :
       {Limit{"k_ascending", model::Direction::ascending, p.k_ascending, "k_descending"},
        Limit{"k_descending", model::Direction::descending, p.k_descending, "k_ascending"}}) {
    const auto allowed = model::allowed_k(p, direction);
    print("# {}: {} = {} 1/{}; {:.6g} to {:.6g} is valid with this {}\n", of, name, k, p.input_unit,
          allowed->lo, allowed->hi, other);
  }
}

/// Checks a single model file and prints its input range and the outputs that it can reach.
int check_model(const std::filesystem::path& file) {
  const model::AnyModel model = config::load_any_model(file);
  std::visit(
      [&](const auto& m) {
        const auto reach = m.reachable(m.virgin(m.input_range().lo));
        print("# {}: kind {}, {} to {} {} reach {:.6g} to {:.6g} {}\n", file.string(), m.kind(),
              m.input_range().lo, m.input_range().hi, m.parameters().input_unit, reach.lo, reach.hi,
              m.parameters().output_unit);
      },
      model);
  if (const auto* recursive = std::get_if<model::Hysteresis>(&model))
    print_limits(file.string(), recursive->parameters());
  return done;
}

std::string in_us(const std::optional<can::Duration>& duration) {
  return duration ? fmt::format("{:.0f}", 1e6 * can::seconds(*duration)) : "unbounded";
}

void show_frame(const config::PlannedFrame& planned) {
  print("# {:<22} 0x{:03X} {:>9} {:>6} {:>9} {:>8}{}\n", planned.frame.name, planned.frame.id,
        in_us(planned.frame.period), can::worst_frame_bits(planned.frame).total(), in_us(planned.response),
        in_us(planned.deadline), planned.in_time() ? "" : "  late");
}

/// Prints the worst-case response time of each frame on the bus. The response time of SYNC, samples and
/// commands counts from the start of the cycle. For all other frames it counts from the time at which the
/// frame is queued.
void show_bus(const config::Config& config) {
  const config::BusPlan plan = config::plan_bus(config);
  print("# the bus at {} bit/s{}, with the maximum of stuff bits; times in us:\n",
        config.bus.bitrate_bit_per_s,
        config.bus.data_bitrate_bit_per_s == 0
            ? ""
            : fmt::format(" and {} bit/s in the data phase", config.bus.data_bitrate_bit_per_s));
  print("# {:<22} {:>5} {:>9} {:>6} {:>9} {:>8}\n", "frame", "id", "period", "bits", "response", "deadline");
  for (const config::PlannedFrame& planned : plan.frames) show_frame(planned);
  print("# emergencies, sent when an axis stops:\n");
  for (const config::PlannedFrame& planned : plan.emergencies) show_frame(planned);
  print("# bus load {:.1f} %; the last command starts at most {} us after its SYNC; the cycle is {} us\n",
        1e2 * plan.load, in_us(plan.last_command), in_us(plan.cycle));
}

/// Prints a warning if the twin's amplifier interpolates its commands but the controller assumes that it
/// holds them, or vice versa. The configuration is still accepted: it can rehearse such a mismatch of a real
/// bench.
void show_mismatch(const config::AxisConfig& axis) {
  if (axis.twin.interpolate == axis.control.delays.interpolated) return;
  print(
      "# warning: axis {}: the twin has interpolate = {}, axis.control.delays has interpolated = {}, "
      "expected the same; the controller looks ahead in the reference by half a cycle too much or too little\n",
      axis.wire.name, axis.twin.interpolate, axis.control.delays.interpolated);
}

/// Describes the drive range through which start_up = "wipe" moves the actuator. The movement erases the
/// unknown hysteresis memory, so that the model knows the complete memory afterwards.
std::string start_up_text(const config::AxisConfig& axis) {
  const controller::Gate::Config& gate = axis.control.gate;
  const model::Interval& thresholds = axis.control.law.model.input_range();
  const std::string& unit = axis.wire.drive_unit;
  if (gate.drive_min <= thresholds.lo)
    return fmt::format("start_up = \"wipe\" moves the drive to both thresholds, {:.6g} and {:.6g} {}",
                       thresholds.hi, thresholds.lo, unit);
  return fmt::format(
      "start_up = \"wipe\" moves the drive only to the upper threshold of the model, {:.6g} {}, which "
      "erases the memory: the drive range does not reach the lower threshold, {:.6g} {}",
      thresholds.hi, unit, thresholds.lo, unit);
}

/// Checks a configuration. Prints its effective values and the results that follow from them, for example the
/// bus load and the positions that each axis can reach. Moves nothing and opens no interface.
int check(const std::filesystem::path& file) {
  if (config::is_model_file(file)) return check_model(file);
  const config::Config config = config::load(file);
  print("# {}, with the effective values\n{}\n", file.string(), config::echo(file));
  const double cycle_s = 1.0 / config.controller.rate_Hz;
  for (const config::AxisConfig& axis : config.axes) {
    const model::Interval drives = controller::model_drives(axis.control.law.model, axis.control.gate);
    const model::Interval reach = controller::model_reach_um(axis.control.law.model, axis.control.gate);
    const double preview_s =
        controller::chain_moments(axis.control.delays, axis.control.law.notch, cycle_s).mean_s;
    print("# axis {}: {} to {} {} reach {:.4g} to {:.4g} um; the reference is previewed by {:.4g} ms\n",
          axis.wire.name, drives.lo, drives.hi, axis.wire.drive_unit, reach.lo, reach.hi, 1e3 * preview_s);
    if (const auto& creep = axis.control.law.creep)
      print("# axis {}: the inverse compensates creep: {:g} % per decade of time from {:g} to {:g} s\n",
            axis.wire.name, 100.0 * creep->per_decade, creep->from_s, creep->to_s);
    print("# axis {}: {}\n", axis.wire.name, start_up_text(axis));
    for (const auto findings : {config::findings_of_loop, config::findings_of_rate})
      for (const config::Finding& finding : findings(axis, config.controller.rate_Hz))
        print("# axis {}: {}\n", axis.wire.name, line_of(finding));
    for (const std::string& finding : config::findings_of_learning(axis, config.controller.rate_Hz))
      print("# axis {}: {}\n", axis.wire.name, finding);
    for (const std::string& loss : config::losses(axis.wire)) print("# axis {}: {}\n", axis.wire.name, loss);
    for (const std::string& name : config::fd_messages(axis.wire, config.database))
      print("# axis {}: {} is sent as CAN FD, and the interface must support FD\n", axis.wire.name, name);
    print_limits("axis " + axis.wire.name, axis.control.law.model);
    if (const auto* twin = std::get_if<model::HysteresisParameters>(&axis.twin.plant.hysteresis))
      print_limits("axis " + axis.wire.name + ", twin", *twin);
  }
  show_bus(config);
  print("# {} in {}: node ids, identifiers, units and ranges agree with the configuration\n",
        counted(config.database.messages.size(), "message"), config.bus.dbc.string());
  for (const config::AxisConfig& axis : config.axes) show_mismatch(axis);
  for (const auto warnings :
       {config::setpoint_warnings, config::supervision_warnings, config::stroke_warnings,
        config::protection_warnings, config::format_warnings, config::command_warnings})
    for (const std::string& warning : warnings(config)) print("# warning: {}\n", warning);
  for (const std::string& warning : config.database.warnings) print("# warning: {}\n", warning);
  if (config.database.further_warnings > 0)
    print("# warning: {} of the DBC not shown\n", counted(config.database.further_warnings, "more warning"));
  return done;
}

constexpr std::size_t axes_max = 16;

struct WiringName {
  config::Wiring wiring;
  const char* key;
  const char* heading;
};
constexpr std::array wirings{
    WiringName{config::Wiring::classical, "classical", "classical CAN"},
    WiringName{config::Wiring::fd, "fd", "CAN FD"},
    WiringName{config::Wiring::fd_shared, "fd_shared", "FD, all axes in a frame"},
    WiringName{config::Wiring::fd_slots, "fd_slots", "the same with own slots"},
};

/// The highest possible cycle rate of a wiring, and the timing of the bus at this rate. If even 1 Hz is too
/// fast for the bus, rate_Hz is 0, and `plan` is the timing at 1 Hz.
struct Limit {
  double rate_Hz;
  config::BusPlan plan;
};

Limit limit_of(const WiringName& wiring, std::size_t axes, const config::Config& like) {
  config::Config config = config::wired_as(wiring.wiring, axes, like);
  config.controller.rate_Hz = config::rate_max_Hz;
  const double rate_Hz = config::fastest_rate_Hz(config);
  config.controller.rate_Hz = std::max(rate_Hz, 1.0);
  return {rate_Hz, config::plan_bus(config)};
}

void print_rates(const config::Config& config) {
  const can::BitRates rates = config::wired_as(config::Wiring::fd, 1, config).bus.rates();
  print(
      "# the highest rate_Hz at which every command starts before the next SYNC, "
      "even if nodes send at any time\n");
  print(
      "# at {} bit/s and {} bit/s in the data phase, with a turnaround of {} us and AmpStatus every {} cycles\n",
      rates.nominal_bit_per_s, rates.data_bit_per_s, in_us(config.bus.turnaround),
      config.axes.front().twin.status_every);
  print("# column us: the latest start of the last command, in us after its SYNC\n");
  print("{:4}", "");
  for (const WiringName& wiring : wirings) print("   {:<23}", wiring.heading);
  print("\naxes");
  for (std::size_t i = 0; i < wirings.size(); ++i) print("   {:>7}  {:>6}  {:>6}", "rate_Hz", "load %", "us");
  print("\n");
  for (std::size_t axes = 1; axes <= axes_max; ++axes) {
    print("{:>4}", axes);
    for (const WiringName& wiring : wirings) {
      const Limit limit = limit_of(wiring, axes, config);
      print("   {:>7g}  {:>6.1f}  {:>6}", limit.rate_Hz, 1e2 * limit.plan.load,
            in_us(limit.plan.last_command));
    }
    print("\n");
  }
}

void print_rates_json(const config::Config& config) {
  const can::BitRates rates = config::wired_as(config::Wiring::fd, 1, config).bus.rates();
  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t axes = 1; axes <= axes_max; ++axes) {
    nlohmann::json row{{"axes", axes}};
    for (const WiringName& wiring : wirings) {
      const Limit limit = limit_of(wiring, axes, config);
      nlohmann::json& entry = row[wiring.key];
      entry = {{"rate_Hz", limit.rate_Hz}, {"load_percent", 1e2 * limit.plan.load}, {"response_us", nullptr}};
      if (limit.plan.last_command) entry["response_us"] = 1e6 * can::seconds(*limit.plan.last_command);
    }
    rows.push_back(std::move(row));
  }
  print("{}\n", nlohmann::json{{"bitrate_bit_per_s", rates.nominal_bit_per_s},
                               {"data_bitrate_bit_per_s", rates.data_bit_per_s},
                               {"turnaround_us", 1e6 * can::seconds(config.bus.turnaround)},
                               {"rows", std::move(rows)}}
                    .dump(2));
}

struct CheckArguments {
  std::filesystem::path file;
  bool rates = false;
  bool json = false;
};

int run_check(const CheckArguments& options) {
  if (!options.rates) return check(options.file);
  // For --rates, loads the configuration without checks. The checks would reject a rate_Hz that is too high
  // for the bus, but --rates does not use rate_Hz: it computes the highest rate.
  const config::Config config =
      config::load_as_written(options.file.empty() ? shipped_file("piezo.toml") : options.file);
  if (options.json)
    print_rates_json(config);
  else
    print_rates(config);
  return done;
}

}  // namespace

void add_check(CLI::App& cli, int& status) {
  auto options = std::make_shared<CheckArguments>();
  CLI::App* command = cli.add_subcommand("check", "Check a configuration and show the effective values");
  command->add_option("CONFIG", options->file,
                      "configuration or model file (TOML); default with --rates: the shipped piezo stage");
  CLI::Option* rates = command->add_flag(
      "--rates", options->rates,
      "print only the highest control rate for 1 to 16 axes on a bus, with classical CAN and with CAN FD");
  command->add_flag("--json", options->json, "print the rates as JSON")->needs(rates);
  command->callback([options, &status] {
    if (options->file.empty() && !options->rates) throw CLI::RequiredError("CONFIG");
    status = print_for_reader([&] { return run_check(*options); });
  });
}

}  // namespace hystcan::app
