#include "app/stage/stage_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>
#include <variant>

#include "app/live/stop_signal.h"
#include "app/stage/axis_completion.h"
#include "app/stage/cautious_excitation.h"
#include "app/stage/config_edit.h"
#include "app/stage/dynamics_text.h"
#include "app/stage/first_stage.h"
#include "app/stage/new_folder.h"
#include "app/stage/rate_choice.h"
#include "app/stage/shipped.h"
#include "base/error.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "config/document/toml_edit.h"
#include "config/document/toml_text.h"
#include "config/files/model_file.h"
#include "config/schema/check.h"
#include "config/schema/config.h"
#include "config/schema/frames.h"
#include "config/schema/setpoint_warnings.h"

namespace hystcan::app {
namespace {

constexpr const char* first_config = "first.toml";
constexpr const char* stage_config = "stage.toml";
constexpr const char* fast_config = "stage.fast.toml";

void copy_into(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::copy_file(file, folder / file.filename(), error);
  if (error) throw RunError(file, fmt::format("cannot be copied: {}", error.message()));
}

/// Runs `body`. In its errors, replaces the path of the temporary folder by the final path.
template <class Body>
void naming(const std::filesystem::path& folder, const std::filesystem::path& temporary, const Body& body) {
  const std::string from = temporary.string();  // copied first, because `body` may rename the folder
  try {
    body();
  } catch (PlacedError& error) {
    error.rename_folder(from, folder.string());
    throw;
  }
}

/// Names of new files in a folder. The destructor removes these files unless keep() was called.
class NewFiles {
 public:
  NewFiles(std::filesystem::path folder, std::vector<std::string> names)
      : folder_(std::move(folder)), names_(std::move(names)) {
    std::vector<std::string> existing;
    for (const std::string& name : names_)
      if (std::filesystem::exists(folder_ / name)) existing.push_back(name);
    if (!existing.empty())
      throw Error(folder_, fmt::format("{} already {}, and nothing is overwritten; move {} away first",
                                       fmt::join(existing, ", "), existing.size() == 1 ? "exists" : "exist",
                                       existing.size() == 1 ? "it" : "them"));
  }
  ~NewFiles() {
    std::error_code ignored;
    if (!kept_)
      for (const std::string& name : names_) std::filesystem::remove_all(folder_ / name, ignored);
  }
  NewFiles(const NewFiles&) = delete;
  NewFiles& operator=(const NewFiles&) = delete;
  void keep() { kept_ = true; }

 private:
  std::filesystem::path folder_;
  std::vector<std::string> names_;
  bool kept_ = false;
};

/// Prints the same warnings as `hystcan check`.
void print_findings(const config::Config& config) {
  for (const config::AxisConfig& axis : config.axes) {
    for (const auto findings : {config::findings_of_loop, config::findings_of_rate})
      for (const config::Finding& finding : findings(axis, config.controller.rate_Hz))
        if (finding.is_warning) print(fmt::format("{}: {}\n", axis.wire.name, line_of(finding)));
    print_lines(axis.wire.name, config::losses(axis.wire));
  }
  for (const auto warnings :
       {config::supervision_warnings, config::stroke_warnings, config::setpoint_warnings})
    for (const std::string& warning : warnings(config)) print(fmt::format("warning: {}\n", warning));
}

std::vector<std::string> loop_names(const std::vector<TuningReport>& tuned) {
  std::vector<std::string> names;
  names.reserve(tuned.size());
  for (const TuningReport& report : tuned) names.push_back(loop_name(report));
  return names;
}

void print_promises(const std::vector<Promise>& promises) {
  for (const Promise& promise : promises) {
    print(text_of(promise) + '\n');
    if (const std::string warning = warning_of(promise); !warning.empty()) print(warning + '\n');
  }
  flush_output();
}

/// Writes stage.fast.toml with the loops that faster_of() returns, rehearses it and prints its promises.
void rehearse_fast(const Stage& stage, const std::vector<TuningReport>& tuned) {
  const std::filesystem::path file = stage.file().parent_path() / fast_config;
  Stage fast(file, stage.text());
  std::vector<std::string> loops = loop_names(tuned);
  for (std::size_t i = 0; i < tuned.size(); ++i)
    if (const Candidate* faster = faster_of(tuned[i])) {
      loops[i] = faster->name;
      controller::LoopConfig loop = faster->loop;
      loop.delays = in_whole_microseconds(loop.delays);
      set_loop(fast.config.axes[i].control, loop);
    }
  const std::string text = fast.text();
  const config::Config config = config::load_text(file, text);
  write_file(file, text);
  print_promises(rehearsal_of(config, tuned, loops));
}

using Plants = std::vector<std::optional<IdentifiedPlant>>;

/// Identifies the dynamics of every axis from its step record, if it has one.
Plants shown_plants(const Stage& stage, const std::vector<AxisRecords>& records) {
  Plants plants;
  plants.reserve(records.size());
  for (std::size_t i = 0; i < records.size(); ++i)
    plants.push_back(shown_plant(records[i], stage.config.axes[i].control.delays));
  return plants;
}

/// Tunes the loop of every axis, writes the configuration, then rehearses all axes together.
void tune_and_rehearse(Stage& stage, const std::vector<AxisRecords>& records, const Plants& plants) {
  std::vector<TuningReport> tuned;
  tuned.reserve(records.size());
  for (std::size_t i = 0; i < records.size(); ++i)
    tuned.push_back(tune_axis(stage, i, records[i], plants[i]));
  const std::string text = stage.text();
  const config::Config config = config::load_text(stage.file(), text);  // throws if `text` is invalid
  write_file(stage.file(), text);
  print_findings(config);
  print_promises(rehearsal_of(config, tuned, loop_names(tuned)));
  if (std::ranges::any_of(tuned, faster_of)) rehearse_fast(stage, tuned);
}

/// Tunes and rehearses the stage. If a rehearsal fails, calls `keep` to keep the files for `hystcan demo`.
template <class Keep>
void tuned_or_kept(Stage& stage, const std::filesystem::path& folder, const std::vector<AxisRecords>& records,
                   const Plants& plants, const Keep& keep) {
  try {
    tune_and_rehearse(stage, records, plants);
  } catch (RunError& error) {
    if (stop_signalled != 0) throw;
    if (!std::filesystem::exists(stage.file())) write_file(stage.file(), stage.text());
    keep();
    error.add_sentence(fmt::format(
        "{} keeps its models and reports, but is not complete: hystcan demo --config {} shows the failed run",
        folder.string(), shell_word(folder / stage_config)));
    throw;
  }
}

/// Returns the command that runs the nodes of the stage: `node` for an analogue card, otherwise `twin`.
std::string_view nodes_of(const config::Config& config) {
  return config.axes.front().analogue ? "node" : "twin";
}

/// Prints the next commands, with the final path `folder`. `made`: present path, temporary before commit().
void print_ready(const std::filesystem::path& made, const std::filesystem::path& folder,
                 std::string_view nodes) {
  const std::string file = shell_word(folder / stage_config), fast = shell_word(folder / fast_config);
  print(
      fmt::format("\n{0}: complete. Next:\n"
                  "  hystcan check {0}                  # the active values, the bus, the margins\n"
                  "  hystcan demo --config {0}          # open and closed loop, with a picture\n"
                  "  hystcan {1} {0} & hystcan controller {0}  # in real time; needs the CAN interface\n",
                  file, nodes));
  if (std::filesystem::exists(made / fast_config))
    print(fmt::format("  hystcan demo --config {}     # the faster loop, after the cautious loop has run\n",
                      fast));
}

/// Prints that the sensor node must use the zero and scale of the --record files, and their position range.
void print_positions(const StageFacts& facts, const std::vector<AxisRecords>& records) {
  for (std::size_t i = 0; i < records.size(); ++i) {
    const model::Interval travel_um = records[i].travel_um();
    print(
        fmt::format("{}: the sensor node must send positions with the zero and scale of the --record file, "
                    "{:.4g} to {:.4g} um: with another zero or scale, the limits and the model are wrong\n",
                    facts.axes[i].config.wire.name, travel_um.lo, travel_um.hi));
  }
}

void print_excitations(const std::filesystem::path& folder, const config::Config& config) {
  const std::string file = shell_word(folder / first_config);
  print(
      fmt::format("{}: the model is a straight line until there are records. "
                  "Next (--rehearse tries a command on the twin):\n",
                  file));
  if (config.axes.front().analogue) print(fmt::format("  hystcan node {} &\n", file));
  for (const config::AxisConfig& axis : config.axes) {
    const std::string& name = axis.wire.name;
    const auto command = [&](const char* output, const std::string& more) {
      print(fmt::format("  hystcan excite {} --axis {} --output {}{}\n", file, shell_word(name),
                        shell_word(folder / (name + "." + output + ".csv")), more));
    };
    command("loops", "");
    const double period_s = quasi_static_period_s(axis.control.delays.resonance_Hz);
    command("slow", fmt::format(" --period {:g}", 4.0 * period_s));
    command("unseen", fmt::format(" --period {:g} --levels 3", 2.0 * period_s));
    command("step", " --signal step");
  }
  print(fmt::format("  hystcan init {} --continue\n", shell_word(folder)));
}

/// Writes provisional models of an axis for which no model was measured.
void write_first_models(const std::filesystem::path& folder, AxisFacts& axis) {
  axis.config.control_model = axis.config.wire.name + ".first.model.toml";
  axis.config.twin_model = axis.config.wire.name + ".first.plant.toml";
  write_file(folder / axis.config.control_model,
             "# A straight line through the travel, until there is a measured model.\n" +
                 config::model_text(straight_line(axis), {}));
  write_file(folder / axis.config.twin_model,
             "# The twin's actuator: a typical loop of a piezo stack, until a loop is measured.\n" +
                 config::model_text(usual_loop(axis), {}));
}

/// Writes the identified model of an axis and the twin's actuator; sets the noise of the twin's sensor.
void write_measured_models(const std::filesystem::path& folder, AxisFacts& axis, const AxisRecords& records) {
  const std::string& name = axis.config.wire.name;
  const identification::Identified found = identify_axis(
      folder, name, records, {axis.config.control.gate.drive_min, axis.config.control.gate.drive_max});
  axis.config.control_model = model_name(name);
  axis.config.twin_model = plant_name(name);
  axis.config.twin.sensor.noise_um_rms = std::max(found.datasets.front().noise, 1e-6 * axis.travel_um.span());
}

AxisRecords records_beside(const std::filesystem::path& folder, const config::AxisConfig& axis, bool accept) {
  const auto named = [&](const char* what) { return folder / (axis.wire.name + "." + what + ".csv"); };
  const auto if_there = [](std::filesystem::path file) {
    return std::filesystem::exists(file) ? std::optional(std::move(file)) : std::nullopt;
  };
  AxisRecords records{.loop_files = {named("loops")},
                      .step_file = if_there(named("step")),
                      .unseen_file = if_there(named("unseen"))};
  if (!std::filesystem::exists(records.loop_files.front()))
    throw Error(records.loop_files.front(), "is missing",
                expect("the record of `hystcan excite {} --axis {}`", shell_word(folder / first_config),
                       shell_word(axis.wire.name)));
  if (auto slow = if_there(named("slow"))) records.loop_files.push_back(*slow);
  DatasetInput input;
  input.input_unit = axis.wire.drive_unit;
  input.output_unit = "um";
  load(records, input, accept);
  return records;
}

/// Replaces reference levels that the model cannot reach by levels that it can reach, and prints a note.
void fit_reference(config::AxisConfig& axis, const model::HysteresisParameters& parameters) {
  constexpr double share = 0.02;
  const model::Interval reach = controller::model_reach_um(parameters, axis.control.gate);
  const model::Interval safe{reach.lo + share * reach.span(), reach.hi - share * reach.span()};
  bool is_moved = false;
  const auto fit = [&](double& um) {
    if (reach.contains(um)) return;
    um = rounded(std::clamp(um, safe.lo, safe.hi), 4);
    is_moved = true;
  };
  for (std::size_t j = 0; j < axis.control.setpoint.size(); ++j) {
    is_moved = false;
    auto& shape = axis.control.setpoint[j].shape;
    if (auto* triangle = std::get_if<controller::Triangle>(&shape)) {
      fit(triangle->low_um);
      fit(triangle->high_um);
    }
    if (auto* stairs = std::get_if<controller::Staircase>(&shape))
      std::ranges::for_each(stairs->levels_um, fit);
    if (is_moved)
      print_lines(
          axis.wire.name,
          {fmt::format("setpoint[{}] was moved into the range that the model reaches, {:.4g} to {:.4g} um", j,
                       reach.lo, reach.hi)});
  }
}

/// Sets the position limits from recorded loops over the whole drive range. The earlier limits depend on the
/// stated or assumed sensor reading at the safe drive, which may be wrong.
void fit_limits(config::AxisConfig& axis, const AxisRecords& records) {
  const controller::Gate::Config& gate = axis.control.gate;
  const controller::Supervisor::Config before = axis.control.supervision;
  const model::Interval drive = records.drive();
  if (drive.span() < 0.95 * (gate.drive_max - gate.drive_min)) {
    print_lines(axis.wire.name, {fmt::format("the record has the drives {:.4g} to {:.4g} of {:g} to {:g} {}, "
                                             "so the model and the drive are limited to that part; "
                                             "the position limits are those of {}",
                                             drive.lo, drive.hi, gate.drive_min, gate.drive_max,
                                             axis.wire.drive_unit, first_config)});
    return;
  }
  const model::Interval travel = records.travel_um();
  const model::Interval limits = position_limits_um(travel);
  constexpr double far_off = 0.05;
  if (std::max(std::abs(limits.lo - before.position_min_um), std::abs(limits.hi - before.position_max_um)) <
      far_off * travel.span())
    return;
  axis.control.supervision.position_min_um = rounded(limits.lo, 3);
  axis.control.supervision.position_max_um = rounded(limits.hi, 3);
  print_lines(
      axis.wire.name,
      {fmt::format("limits: position {:.3g} to {:.3g} um, 15 % beyond the record's {:.4g} to {:.4g} um; "
                   "previously {:g} to {:g} um",
                   limits.lo, limits.hi, travel.lo, travel.hi, before.position_min_um,
                   before.position_max_um)});
}

/// Prints whether another cycle rate is better. Uses the better rate if the user did not state a rate, and if
/// the better rate halves the error or the default rate excites a mode.
void choose_rate(const std::filesystem::path& file, StageFacts& facts, const Plants& plants) {
  const ConfigAtRate at_rate = [&](double rate_Hz) {
    StageFacts other = facts;
    other.config.controller.rate_Hz = rate_Hz;
    Stage stage(file, config_text(other));
    for (std::size_t i = 0; i < plants.size(); ++i) set_cautious_loop(stage, i, plants[i]);
    return config::load_text(file, stage.text());
  };
  const double usual_Hz = facts.config.controller.rate_Hz;
  const config::Config usual = at_rate(usual_Hz);
  const std::vector<double> rates_Hz = rates_to_try(usual);
  if (rates_Hz.empty()) return;
  const std::vector<Promise> present = promises_with_best_feed_forward(usual);
  const auto offer = better_rate(at_rate, rates_Hz, present);
  if (!offer) return;
  const bool rings = std::ranges::any_of(
      usual.axes, [&](const config::AxisConfig& axis) { return config::rings_at(axis, usual_Hz); });
  if (facts.rate_is_assumed && (rings || offer->share < 0.5))
    facts.config.controller.rate_Hz = offer->rate_Hz;
  const bool is_taken = facts.config.controller.rate_Hz == offer->rate_Hz;
  const std::string end =
      is_taken ? fmt::format(" at {:g} Hz; the cycle rate is now {:g} Hz", usual_Hz, offer->rate_Hz)
               : std::string(" (--cycle-rate)");
  for (const std::string& text : texts_of(*offer, present)) print(text + end + '\n');
  flush_output();
}

}  // namespace

void make_stage(const std::filesystem::path& folder, StageFacts facts,
                const std::vector<AxisRecords>& records) {
  NewFolder made(folder);
  naming(folder, made.path(), [&] {
    copy_into(facts.config.bus.dbc, made.path());
    for (std::size_t i = 0; i < facts.axes.size(); ++i) {
      if (records.empty())
        write_first_models(made.path(), facts.axes[i]);
      else
        write_measured_models(made.path(), facts.axes[i], records[i]);
    }
    const std::filesystem::path file = made.path() / (records.empty() ? first_config : stage_config);
    Stage stage(file, config_text(facts));
    if (records.empty()) {
      write_file(file, stage.text());
      print_excitations(folder, stage.config);
      return;
    }
    const Plants plants = shown_plants(stage, records);
    choose_rate(file, facts, plants);
    stage = Stage(file, config_text(facts));
    tuned_or_kept(stage, folder, records, plants, [&] { made.commit(); });
    print_positions(facts, records);
    print_ready(made.path(), folder, nodes_of(stage.config));
  });
  made.commit();
}

void continue_stage(const std::filesystem::path& folder, const ModelWords& model, bool accept) {
  const std::filesystem::path file = folder / first_config;
  if (!std::filesystem::exists(file) && std::filesystem::exists(folder / stage_config))
    throw Error(
        folder, "was created with --record, so there is nothing to continue",
        {.remedy = fmt::format(
             "edit {0} and try this file with `hystcan demo --config {0}`, or create the folder again",
             shell_word(folder / stage_config))});
  if (!std::filesystem::exists(file)) throw Error(file, "is missing", expect("a folder of `hystcan init`"));
  Stage first(file, config::TomlEdit::of_file(file).text());
  std::vector<AxisRecords> records;
  std::vector<std::string> names{stage_config, fast_config};
  for (const config::AxisConfig& axis : first.config.axes) {
    records.push_back(records_beside(folder, axis, accept));
    model.apply_to(records.back().model);
    const controller::Gate::Config& gate = axis.control.gate;
    refuse_contradictions(records.back(), axis.wire.drive_unit, {gate.drive_min, gate.drive_max}, {});
    const std::string& name = axis.wire.name;
    for (const std::string& made : {model_name(name), plant_name(name), name + ".report", name + ".bode.svg",
                                    name + ".bode.data.csv", name + ".bode.json"})
      names.push_back(made);
  }
  NewFiles made(folder, names);
  for (std::size_t i = 0; i < records.size(); ++i) {
    config::AxisConfig& axis = first.config.axes[i];
    const identification::Identified found = identify_axis(
        folder, axis.wire.name, records[i], {axis.control.gate.drive_min, axis.control.gate.drive_max});
    axis.control_model = model_name(axis.wire.name);
    axis.twin_model = plant_name(axis.wire.name);
    fit_limits(axis, records[i]);
    fit_reference(axis, found.parameters);
  }
  Stage stage(folder / stage_config, first.text());
  tuned_or_kept(stage, folder, records, shown_plants(stage, records), [&] { made.keep(); });
  made.keep();
  print_ready(folder, folder, nodes_of(stage.config));
}

void copy_preset(const std::string& preset, const std::filesystem::path& folder) {
  const std::vector<std::string> known = shipped_configurations();
  if (std::ranges::find(known, preset) == known.end())
    throw Error(fmt::format("--from {} is not a shipped configuration", preset),
                expect("one of {}", fmt::join(known, ", ")));
  const std::filesystem::path shipped = shipped_file(preset + ".toml");
  const config::Config config = config::load(shipped);
  std::vector<std::filesystem::path> files{shipped, shipped.parent_path() / config.bus.dbc};
  for (const config::AxisConfig& axis : config.axes)
    for (const auto& model : {axis.control_model, axis.twin_model})
      files.push_back(shipped.parent_path() / model);
  std::ranges::sort(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  NewFolder made(folder);
  for (const auto& file : files) copy_into(file, made.path());
  made.commit();
  for (const auto& file : files) print(fmt::format("{}\n", (folder / file.filename()).string()));
  print(fmt::format("next: hystcan demo --config {}\n", shell_word(folder / shipped.filename())));
}

}  // namespace hystcan::app
