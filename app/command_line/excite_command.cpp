#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "app/command_line/commands.h"
#include "app/live/report.h"
#include "app/stage/cautious_excitation.h"
#include "app/stage/config_edit.h"
#include "app/stage/open_loop.h"
#include "app/stage/option_check.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "config/schema/config.h"
#include "controller/excitation_dataset.h"

namespace hystcan::app {
namespace {

using controller::Excitation;

struct ExciteArguments {
  OpenLoopOptions run;
  std::filesystem::path output;
  std::string signal = "hysteresis";
  std::optional<double> low, high, slew_per_s, period_s, amplitude, from_Hz, to_Hz, duration_s;
  std::optional<unsigned> cycles, levels;
  bool overwrite = false;
};

/// Returns the duration of one major loop in s: the option --period, or a time that is slow compared with the
/// resonance.
double loop_period_s(const ExciteArguments& options, const config::Config& config) {
  return options.period_s.value_or(quasi_static_period_s(config.axes[0].control.delays.resonance_Hz));
}

Excitation::Config excitation(const ExciteArguments& options, const config::Config& config) {
  const controller::Gate::Config& gate = config.axes[0].control.gate;
  const double rate_Hz = config.controller.rate_Hz;
  constexpr double rest_cycles = 10.0;
  const double low = options.low.value_or(gate.drive_min);
  const double high = options.high.value_or(gate.drive_max);
  if (!(low < high)) throw Error(fmt::format("--low is {}", low), expect("less than --high, {}", high));
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
    if (chirp.from_Hz > chirp.to_Hz)
      throw Error(fmt::format("--frequency-from is {} Hz", chirp.from_Hz),
                  expect("at most --frequency-to, {} Hz", chirp.to_Hz));
    if (chirp.to_Hz > rate_Hz / 2.0)
      throw Error(fmt::format("--frequency-to is {} Hz", chirp.to_Hz),
                  expect("at most half the cycle rate, {} Hz", rate_Hz / 2.0));
    return chirp;
  }
  return Excitation::Hysteresis{
      .low = low,
      .high = high,
      .slew_per_s = options.slew_per_s.value_or(2.0 * (high - low) / loop_period_s(options, config)),
      .rest_s = rest_cycles / rate_Hz,
      .loops = options.cycles.value_or(2),
      .levels = options.levels.value_or(5)};
}

/// Writes the dataset as CSV. If writing fails during the run, the run continues and close() throws the
/// error.
class DatasetRecorder {
 public:
  DatasetRecorder(OutputFile& file, const ExciteArguments& options, const config::Config& config,
                  double lead_s)
      : file_(file), record_(lead_s) {
    const config::AxisConfig& axis = config.axes[0];
    file_.write(fmt::format("# {} excitation of axis {} at {:.17g} Hz, {} with {}\n", options.signal,
                            axis.wire.name, config.controller.rate_Hz,
                            options.run.rehearse ? "rehearsed" : "recorded",
                            config.file.filename().string()));
    file_.write(fmt::format("# input_unit = \"{}\"\n# output_unit = \"um\"\n", axis.wire.drive_unit));
    file_.write("# input: the drive from this row's SYNC to the next; output: the position at this SYNC\n");
    file_.write("time_s,input,output\n");
  }

  void add(const controller::CycleRecord& record) {
    const auto row = record_.add(record);
    if (!row || !lost_.empty()) return;
    widen(input_, row->input);
    widen(output_, row->output);
    try {
      file_.write(fmt::format("{:.17g},{:.17g},{:.17g}\n", row->time_s, row->input, row->output));
    } catch (const RunError& error) {
      lost_ = error.what();
    }
  }

  /// Completes the file. A file without rows is removed. Throws RunError if a row could not be written.
  void close() {
    if (!lost_.empty()) throw RunError(lost_);
    if (record_.rows() > 0) file_.commit();
  }

  std::uint64_t rows() const { return record_.rows(); }

  std::string summary(const std::string& drive_unit) const {
    return fmt::format(
        "{}, {} left out because data is missing, input {:g} to {:g} {}, output {:.4f} to {:.4f} um",
        counted(record_.rows(), "row"), counted(record_.left_out(), "cycle"), input_.lo, input_.hi,
        drive_unit, output_.lo, output_.hi);
  }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static void widen(model::Interval& range, double value) {
    range = {std::min(range.lo, value), std::max(range.hi, value)};
  }

  OutputFile& file_;
  controller::ExcitationDataset record_;
  model::Interval input_{infinity, -infinity}, output_{infinity, -infinity};
  std::string lost_;
};

/// Returns true if the options do not give the size of the excitation: the drive range of loops, or the
/// amplitude of a step or chirp. The program then chooses the size.
bool chooses_size(const ExciteArguments& options) {
  return options.signal == "hysteresis" ? !options.low && !options.high : !options.amplitude;
}

/// Returns the excitation that the options describe. If the options give no size, trials determine the size:
/// on the stage for loops, on the twin for step and chirp.
Excitation::Config chosen_excitation(const ExciteArguments& options, const config::Config& config,
                                     const twin::Config& twin) {
  const Excitation::Config stated = excitation(options, config);
  if (!chooses_size(options)) return stated;
  if (const auto* loops = std::get_if<Excitation::Hysteresis>(&stated)) {
    in_open_loop(config, stated);  // throws if the excitation exceeds the drive limits
    return tried_small_first(config, twin, options.run, *loops);
  }
  return with_margin(config, twin, stated);
}

/// Prints the commands for two further records of loops. In the first one the loops are slower, because loops
/// at a single rate cannot separate delay from hysteresis. The second one validates the model, because a
/// model must be validated with a record from which it was not identified.
void propose_further(const ExciteArguments& options, const config::Config& config) {
  if (options.signal != "hysteresis" || options.period_s || options.slew_per_s || options.levels) return;
  const double period_s = loop_period_s(options, config);
  std::string stem =
      options.output.stem().string();  // x.loops.csv -> x.slow.csv, the name that `init --continue` searches
  if (stem.ends_with(".loops")) stem.resize(stem.size() - std::string_view(".loops").size());
  const auto beside = [&](const char* what) {
    return shell_word(options.output.parent_path() / fmt::format("{}.{}.csv", stem, what));
  };
  note(
      "next, repeat this command with the options below: the slow record separates delay from hysteresis; "
      "the record with three levels validates the model\n"
      "  --period {:g} --output {}\n  --period {:g} --levels 3 --output {}\n",
      4.0 * period_s, beside("slow"), 2.0 * period_s, beside("unseen"));
}

/// Adds one loop at the beginning, which is driven but not recorded. If the program chose the size by trials,
/// this loop erases the traces of the smaller trial loops in the stage's memory.
Excitation::Config with_lead(Excitation::Config excitation) {
  if (auto* loops = std::get_if<Excitation::Hysteresis>(&excitation)) ++loops->loops;
  return excitation;
}
double lead_s(const Excitation::Config& excitation) {
  const auto* loops = std::get_if<Excitation::Hysteresis>(&excitation);
  return loops != nullptr ? loop_s(*loops) : 0.0;
}

/// Runs the excitation to its end and keeps the record. If `may_shrink` is true and the run ended with a
/// fault that a smaller excitation may avoid, such as a position limit, discards the record and returns true.
/// Throws RunError if the run ended early for another reason.
bool recorded(OutputFile& file, const ExciteArguments& options, const config::Config& chosen,
              const twin::Config& twin, const Excitation::Config& excitation, bool may_shrink) {
  const bool leads = chooses_size(options);
  const config::Config config = in_open_loop(chosen, leads ? with_lead(excitation) : excitation);
  DatasetRecorder recorder(file, options, config, leads ? lead_s(excitation) : 0.0);
  const std::string& axis = config.axes[0].wire.name;
  const OpenLoopEnd end = drive_in_open_loop(
      config, twin, options.run, [&](const controller::CycleRecord& record) { recorder.add(record); });
  for (const std::string& line : end.closing) note("{}\n", line);
  if (may_shrink && is_of_size(end.axis.fault())) {
    note(
        "{}. If the measured positions only have a constant offset, state the sensor reading at the "
        "safe drive with hystcan init --sensor-at-safe\n",
        describe(axis, end.axis.fault()));
    return true;
  }
  recorder.close();
  end.require_finished(axis, recorder.rows() == 0
                                 ? "stopped before the first row; nothing is written"
                                 : fmt::format("stopped after {}; they are in {}",
                                               counted(recorder.rows(), "row"), options.output.string()));
  note("{}: {}\n", options.output.string(), recorder.summary(config.axes[0].wire.drive_unit));
  return false;
}

int run_excite(const ExciteArguments& options) {
  constexpr int attempts = 4;
  constexpr double less = 0.6;
  const config::Config loaded = config::load_unmeasured(options.run.config);
  refuse_to_overwrite_inputs(options.output, options.run.config, loaded);
  refuse_to_replace(options.output, options.overwrite);
  // Opens the output file before the axis moves, so that an unwritable file stops the command early.
  auto file = std::make_unique<OutputFile>(options.output);
  const config::Config chosen = chosen_axis_of(loaded, options.run);
  const twin::Config twin = twin_config(loaded);
  Excitation::Config excitation = chosen_excitation(options, chosen, twin);
  for (int left = attempts - 1;
       recorded(*file, options, chosen, twin, excitation, chooses_size(options) && left > 0); --left) {
    file = std::make_unique<OutputFile>(options.output);
    excitation = resized(excitation, less, chosen.axes[0].control.gate.safe_drive);
    const model::Interval range = Excitation(excitation).range();
    note("repeating the excitation with a smaller range, {:.4g} to {:.4g} {}\n", range.lo, range.hi,
         chosen.axes[0].wire.drive_unit);
  }
  propose_further(options, chosen);
  return done;
}

/// Throws Error if the command line contains an option that belongs to another --signal, because the option
/// would have no effect.
void refuse_options_of_other_signals(const CLI::App& command, const std::string& signal) {
  const std::pair<const char*, std::vector<std::string>> table[] = {
      {"--slew", {"hysteresis"}},           {"--levels", {"hysteresis"}},
      {"--period", {"hysteresis", "step"}}, {"--cycles", {"hysteresis", "step"}},
      {"--amplitude", {"step", "chirp"}},   {"--frequency-from", {"chirp"}},
      {"--frequency-to", {"chirp"}},        {"--duration", {"chirp"}}};
  for (const auto& [option, signals] : table)
    if (command.count(option) > 0 && std::ranges::find(signals, signal) == signals.end())
      throw Error(fmt::format("{} is not allowed with --signal {}", option, signal),
                  expect("with {}", fmt::join(signals, " or ")));
}

}  // namespace

void add_excite(CLI::App& cli, int& status) {
  auto options = std::make_shared<ExciteArguments>();
  CLI::App* command =
      cli.add_subcommand("excite", "Drive one axis in open loop and write a dataset for identification");
  command->add_option("CONFIG", options->run.config, "configuration (TOML), with or without a model")
      ->required();
  command->add_option("--output", options->output, "output file (CSV) with time_s,input,output")->required();
  command->add_flag("--overwrite", options->overwrite, "replace an existing file");
  add_checked(*command, "--signal", options->signal, one_of({"hysteresis", "step", "chirp"}),
              "`hysteresis`: slow loops; `step`, `chirp`: small fast signals for the dynamics")
      ->capture_default_str();
  add_checked(*command, "--low", options->low, finite_number(), "lowest drive; default: drive_min");
  add_checked(*command, "--high", options->high, finite_number(),
              "highest drive; default: drive_max. Step and chirp are centred between --low and --high");
  CLI::Option* slew = add_checked(*command, "--slew", options->slew_per_s, positive_number(),
                                  "hysteresis: speed of the drive, in drive units per second");
  add_checked(*command, "--period", options->period_s, positive_number(),
              "seconds per major loop (default: 100 periods of the resonance, at least 2) or per step up and "
              "down (default: 0.4)")
      ->excludes(slew);
  add_checked(*command, "--cycles", options->cycles, whole_number(1, Excitation::most_turns),
              "number of major loops (default: 2) or of steps up and down (default: 5)");
  add_checked(*command, "--levels", options->levels, whole_number(0, Excitation::most_turns),
              "hysteresis: number of nested loops, and of reversal curves in each direction; default: 5");
  add_checked(*command, "--amplitude", options->amplitude, positive_number(),
              "step, chirp: amplitude in drive units; default: 5 % of the range from --low to --high, "
              "or less if the twin comes near a position or jump limit in a rehearsal");
  add_checked(*command, "--frequency-from", options->from_Hz, positive_number(),
              "chirp: first frequency in Hz; default: a thousandth of the cycle rate");
  add_checked(*command, "--frequency-to", options->to_Hz, positive_number(),
              "chirp: last frequency in Hz; default: 0.4 of the cycle rate");
  add_checked(*command, "--duration", options->duration_s, positive_seconds(), "chirp: seconds (10)");
  add_open_loop_options(*command, options->run);
  command->callback([options, command, &status] {
    refuse_options_of_other_signals(*command, options->signal);
    status = run_excite(*options);
  });
}

}  // namespace hystcan::app
