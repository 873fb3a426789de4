#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/live.h"
#include "app/live_run.h"
#include "app/output_file.h"
#include "app/report.h"
#include "app/stop_signal.h"
#include "config/config.h"
#include "controller/excitation_record.h"
#include "controller/telemetry.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {
namespace {

using controller::Excitation;

struct Options {
  std::filesystem::path config;
  std::filesystem::path output;
  std::string axis;
  std::string signal = "hysteresis";
  std::optional<double> low, high, slew_per_s, period_s, amplitude, from_Hz, to_Hz, duration_s;
  std::optional<unsigned> cycles, levels;
  std::string interface;
  bool rehearse = false;
  bool clear_faults = false;
};

Excitation::Config excitation(const Options& options, const controller::Gate::Config& gate, double rate_Hz) {
  constexpr double rest_cycles = 10.0;
  const double low = options.low.value_or(gate.drive_min);
  const double high = options.high.value_or(gate.drive_max);
  if (!(low < high))
    throw config::Error(fmt::format("--low is {}, expected less than --high, {}", low, high));
  if (options.period_s && !(*options.period_s > 0.0))
    throw config::Error(fmt::format("--period is {}, expected seconds > 0", *options.period_s));
  const double centre = low + (high - low) / 2.0;
  const double amplitude = options.amplitude.value_or(0.05 * (high - low));
  if (options.signal == "step")
    return Excitation::Steps{.centre = centre,
                             .amplitude = amplitude,
                             .period_s = options.period_s.value_or(0.4),
                             .cycles = options.cycles.value_or(5)};
  if (options.signal == "chirp") {
    const Excitation::Chirp chirp{.centre = centre,
                                  .amplitude = amplitude,
                                  .from_Hz = options.from_Hz.value_or(rate_Hz / 1000.0),
                                  .to_Hz = options.to_Hz.value_or(0.4 * rate_Hz),
                                  .duration_s = options.duration_s.value_or(10.0)};
    if (std::max(chirp.from_Hz, chirp.to_Hz) > rate_Hz / 2.0)
      throw config::Error(fmt::format("the chirp goes to {} Hz, expected at most half the cycle rate, {} Hz",
                                      std::max(chirp.from_Hz, chirp.to_Hz), rate_Hz / 2.0));
    return chirp;
  }
  return Excitation::Hysteresis{
      .low = low,
      .high = high,
      .slew_per_s = options.slew_per_s.value_or(2.0 * (high - low) / options.period_s.value_or(2.0)),
      .rest_s = rest_cycles / rate_Hz,
      .loops = options.cycles.value_or(2),
      .levels = options.levels.value_or(5)};
}

/// The configuration with the one axis alone, in open loop. The twin stays whole, as on a bus that is there.
config::Config only(config::Config config, const Options& options) {
  auto chosen = config.axes.begin();
  if (!options.axis.empty())
    chosen = std::ranges::find(config.axes, options.axis,
                               [](const config::AxisConfig& axis) { return axis.wire.name; });
  if (chosen == config.axes.end())
    throw config::Error(
        fmt::format("{}: no axis {}, expected one of its names", config.file.string(), options.axis));
  chosen->control.excitation = excitation(options, chosen->control.gate, config.controller.rate_Hz);
  refuse_beyond(chosen->control.gate, Excitation(*chosen->control.excitation));
  config.axes = {config::AxisConfig(*chosen)};
  config.controller.axes = {{.wire = config.axes[0].wire, .axis = config.axes[0].control}};
  if (!options.interface.empty()) config.bus.interface = options.interface;
  return config;
}

void refuse_to_overwrite_inputs(const Options& options, const config::Config& config) {
  const auto folder = options.config.parent_path();
  refuse_to_overwrite(options.output, options.config);
  refuse_to_overwrite(options.output, folder / config.bus.dbc);
  for (const config::AxisConfig& axis : config.axes)
    for (const auto& model : {axis.control_model, axis.twin_model})
      refuse_to_overwrite(options.output, folder / model);
}

/// The CSV. What goes wrong with the file while cycles come in is kept until close().
class Recorder {
 public:
  Recorder(const Options& options, const config::Config& config) : file_(options.output) {
    const config::AxisConfig& axis = config.axes[0];
    file_.write(fmt::format("# {} excitation of axis {} at {:.17g} Hz, {} with {}\n", options.signal,
                            axis.wire.name, config.controller.rate_Hz,
                            options.rehearse ? "rehearsed" : "recorded", config.file.filename().string()));
    file_.write(fmt::format("# input_unit = \"{}\"\n# output_unit = \"um\"\n", axis.drive_unit));
    file_.write(
        "# input: the drive in force from this row's SYNC to the next; output: the position at this SYNC\n");
    file_.write("time_s,input,output\n");
  }

  void add(const controller::CycleRecord& record) {
    const auto row = record_.add(record);
    if (!row || !lost_.empty()) return;
    input_.add(row->input);
    output_.add(row->output);
    line_.clear();
    fmt::format_to(std::back_inserter(line_), "{:.17g},{:.17g},{:.17g}\n", row->time_s, row->input,
                   row->output);
    try {
      file_.write({line_.data(), line_.size()});
    } catch (const RunError& error) {
      lost_ = error.what();
    }
  }

  /// A record without rows is not kept.
  void close() {
    if (!lost_.empty()) throw RunError(lost_);
    if (record_.rows() > 0) file_.commit();
  }

  std::uint64_t rows() const { return record_.rows(); }

  std::string summary(const std::string& drive_unit) const {
    return fmt::format("{} rows, {} cycles left out, input {:g} to {:g} {}, output {:.4f} to {:.4f} um",
                       record_.rows(), record_.left_out(), input_.least, input_.most, drive_unit,
                       output_.least, output_.most);
  }

 private:
  struct Extremes {
    double least = std::numeric_limits<double>::infinity();
    double most = -std::numeric_limits<double>::infinity();
    void add(double value) {
      least = std::min(least, value);
      most = std::max(most, value);
    }
  };

  OutputFile file_;
  controller::ExcitationRecord record_;
  Extremes input_;
  Extremes output_;
  fmt::memory_buffer line_;
  std::string lost_;
};

bool has_ended(const controller::Axis& axis) {
  return axis.report().point.finished || axis.state() == controller::AxisState::faulted;
}

/// How it ended is told by the axis; of the bus there is something to tell where there was a real one.
struct Ended {
  controller::Axis axis;
  std::vector<std::string> closing{};
};

Ended rehearse(const config::Config& config, Recorder& recorder) {
  // Longer than any start-up or ramp down; who has not got there by then never will.
  constexpr auto patience = std::chrono::seconds(60);
  constexpr auto stride = std::chrono::milliseconds(10);
  rehearsal::Rehearsal rehearsal({.controller = config.controller,
                                  .twin = config.twin,
                                  .database = config.database,
                                  .bitrate_bit_per_s = config.bus.bitrate_bit_per_s},
                                 [&](const controller::CycleRecord& record) { recorder.add(record); });
  controller::Controller& loop = rehearsal.controller();
  const auto run_until = [&](auto condition, double limit_s) {
    const can::Time start = rehearsal.clock().now();
    while (!condition() && can::seconds(rehearsal.clock().now() - start) < limit_s) rehearsal.run_for(stride);
  };
  const double patience_s = std::chrono::duration<double>(patience).count();
  stop_at_a_signal();
  rehearsal.start();
  run_until([&] { return has_ended(loop.axis(0)) || stop_signalled != 0; },
            patience_s + Excitation(*config.axes[0].control.excitation).length_s());
  loop.request_stop();
  run_until([&] { return loop.stopped(); }, patience_s);
  return {loop.axis(0)};
}

Ended run_on_the_bus(const config::Config& config, const Options& options, Recorder& recorder) {
  LiveLoop loop(config.bus.interface);
  StateLog log(config);
  controller::BusLog bus_log(config.bus.interface, bus_log_sink());
  std::unique_ptr<controller::TelemetryThread> telemetry;
  controller::Controller controller(config.controller, config.database, loop.scheduler(), loop.attach(),
                                    [&](const controller::CycleRecord& record) { telemetry->push(record); });
  look_at_interface(config, config.bus.interface);
  telemetry = std::make_unique<controller::TelemetryThread>([&](const controller::CycleRecord& record) {
    log.add(record);
    bus_log.write();
    recorder.add(record);
  });
  spdlog::info("{} excitation of axis {}, {:.3g} s at {} Hz on {}; Ctrl-C ramps down and stops",
               options.signal, config.axes[0].wire.name,
               Excitation(*config.axes[0].control.excitation).length_s(), config.controller.rate_Hz,
               config.bus.interface);
  become_realtime(config);
  run_live(loop, controller, bus_log, options.clear_faults,
           [&](double) { return has_ended(controller.axis(0)); });
  telemetry.reset();
  bus_log.write();
  return {controller.axis(0), describe(closing_of(controller, log.events()))};
}

int run_excite(const Options& options) {
  const config::Config loaded = config::load(options.config);
  refuse_to_overwrite_inputs(options, loaded);
  const config::Config config = only(loaded, options);
  Recorder recorder(options, config);
  const auto [axis, closing] =
      options.rehearse ? rehearse(config, recorder) : run_on_the_bus(config, options, recorder);
  for (const std::string& line : closing) fmt::print(stderr, "{}\n", line);
  recorder.close();

  const std::string stopped = recorder.rows() == 0 ? "stopped before the first row, nothing is written"
                                                   : fmt::format("stopped after {} rows, which are in {}",
                                                                 recorder.rows(), options.output.string());
  if (axis.fault().cause != controller::Cause::none)
    throw RunError(describe(config.axes[0].wire.name, axis.fault()) + "; " + stopped);
  if (!axis.report().point.finished) throw RunError(stopped);
  fmt::print(stderr, "{}: {}\n", options.output.string(), recorder.summary(config.axes[0].drive_unit));
  return done;
}

/// An option of another signal would be left unheard.
void refuse_foreign(const CLI::App& command, const std::string& signal) {
  struct Belongs {
    const char* option;
    std::vector<std::string> signals;
  };
  const Belongs table[] = {{"--slew", {"hysteresis"}},           {"--levels", {"hysteresis"}},
                           {"--period", {"hysteresis", "step"}}, {"--cycles", {"hysteresis", "step"}},
                           {"--amplitude", {"step", "chirp"}},   {"--frequency-from", {"chirp"}},
                           {"--frequency-to", {"chirp"}},        {"--duration", {"chirp"}}};
  for (const Belongs& row : table)
    if (command.count(row.option) > 0 && std::ranges::find(row.signals, signal) == row.signals.end())
      throw config::Error(fmt::format("{} does not go with --signal {}, expected with {}", row.option, signal,
                                      fmt::join(row.signals, " or ")));
}

}  // namespace

void add_excite(CLI::App& cli, int& status) {
  auto options = std::make_shared<Options>();
  CLI::App* command = cli.add_subcommand(
      "excite", "Drive one axis in open loop and record what comes of it, to identify from");
  command->add_option("CONFIG", options->config, "configuration (TOML); its model is not used")->required();
  command->add_option("--output", options->output, "CSV to write: time_s,input,output, 17 digits")
      ->required();
  command->add_option("--axis", options->axis, "name of the axis; the first one if left out");
  command
      ->add_option("--signal", options->signal,
                   "hysteresis: slow loops; step, chirp: small and fast, for the dynamics")
      ->check(CLI::IsMember({"hysteresis", "step", "chirp"}))
      ->capture_default_str();
  command->add_option("--low", options->low, "lowest drive; drive_min if left out");
  command->add_option("--high", options->high,
                      "highest drive; drive_max if left out. Step and chirp: about the middle of the two");
  CLI::Option* slew =
      command->add_option("--slew", options->slew_per_s, "hysteresis: drive units per second");
  command
      ->add_option(
          "--period", options->period_s,
          "seconds of one major loop (2) or of one step up and down (0.4). A loop is quasi-static where "
          "it takes 100 / resonance or longer")
      ->excludes(slew);
  command->add_option("--cycles", options->cycles, "major loops (2) or steps up and down (5)");
  command->add_option("--levels", options->levels,
                      "hysteresis: nested loops, and reversal curves each way (5)");
  command->add_option("--amplitude", options->amplitude, "step, chirp: drive units; 5 % of high - low");
  command->add_option("--frequency-from", options->from_Hz, "chirp: Hz; a thousandth of the cycle rate");
  command->add_option("--frequency-to", options->to_Hz, "chirp: Hz; 0.4 of the cycle rate");
  command->add_option("--duration", options->duration_s, "chirp: seconds (10)");
  CLI::Option* interface =
      command->add_option("--interface", options->interface, "CAN interface instead of the configured one");
  CLI::Option* clear = command->add_flag("--clear-faults", options->clear_faults,
                                         "clear a fault the amplifier has latched, then start");
  command->add_flag("--rehearse", options->rehearse, "on the simulated bus, with the twin, in virtual time")
      ->excludes(interface)
      ->excludes(clear);
  command->callback([options, command, &status] {
    refuse_foreign(*command, options->signal);
    status = run_excite(*options);
  });
}

}  // namespace hystcan::app
