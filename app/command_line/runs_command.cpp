#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command_line/commands.h"
#include "base/error.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "runs/run.h"
#include "runs/run_folder.h"

namespace hystcan::app {
namespace {

struct RunsArguments {
  std::filesystem::path folder;
  bool json = false;
};

std::string state_of(const runs::RunInfo& info, bool was_being_recorded) {
  if (!info.failure.empty()) return "ended early: " + info.failure;
  if (!info.ended.empty()) return "closed";
  return was_being_recorded ? "recording" : "not closed (killed)";
}

std::string faults_text(const std::vector<runs::RunFault>& faults) {
  if (faults.empty()) return "-";
  std::string text = fmt::format("{} at {:.3f} s", faults.front().cause, faults.front().time_s);
  if (faults.size() > 1) text += fmt::format(", and {} more", faults.size() - 1);
  return text;
}

void print_run(const runs::Run& run, bool was_being_recorded) {
  const runs::RunInfo& info = run.info();
  std::string name = run.name(), duration = fmt::format("{:.1f}", info.last_s - info.first_s);
  for (const runs::RunAxis& axis : info.axes) {
    const std::string rms = axis.tracked_rows > 0 ? fmt::format("{:.4f}", axis.rms_um) : "-";
    const std::string max = axis.tracked_rows > 0 ? fmt::format("{:.4f}", axis.max_um) : "-";
    print(fmt::format("{:<27} {:>10} {:<8} {:>9} {:>9}  {}\n", name, duration, axis.name, rms, max,
                      faults_text(axis.faults)));
    name.clear();
    duration.clear();
  }
  if (const std::string state = state_of(info, was_being_recorded); state != "closed")
    print(fmt::format("{:<27} {}\n", "", state));
  if (info.rows_lost > 0) print(fmt::format("{:<27} {} rows lost\n", "", info.rows_lost));
}

/// Lists the runs. If a folder cannot be read, continues with the next folder.
int list_runs(const RunsArguments& options) {
  nlohmann::json list = nlohmann::json::array();
  const std::vector<std::filesystem::path> paths = runs::runs_in(options.folder);
  if (!options.json)
    print(fmt::format("{:<27} {:>10} {:<8} {:>9} {:>9}  {}\n", "run", "duration s", "axis", "RMS um",
                      "max um", "faults"));
  for (const std::filesystem::path& path : paths) {
    try {
      const bool is_being_recorded =
          runs::is_being_recorded(path);  // checked before reading, because the recording may end in between
      const runs::Run run(path);
      if (!options.json) {
        print_run(run, is_being_recorded);
        continue;
      }
      nlohmann::json entry = to_json(run.info());
      entry.erase("settings");
      entry.update({{"run", path.string()}, {"state", state_of(run.info(), is_being_recorded)}});
      list.push_back(std::move(entry));
    } catch (const Error& error) {
      note("hystcan: {}\n", error.what());
    }
  }
  if (options.json) print(list.dump(2) + "\n");
  if (!options.json)
    print(fmt::format("{}, {:.1f} MB\n", counted(paths.size(), "run"),
                      1e-6 * static_cast<double>(runs::bytes_of_runs(options.folder))));
  return done;
}

}  // namespace

void add_runs(CLI::App& cli, int& status) {
  auto options = std::make_shared<RunsArguments>();
  CLI::App* command = cli.add_subcommand("runs", "List recorded runs: duration, errors, faults");
  command->add_option("DIR", options->folder, "folder of the runs")->required();
  command->add_flag("--json", options->json, "print the list as JSON");
  command->callback([options, &status] { status = print_for_reader([&] { return list_runs(*options); }); });
}

}  // namespace hystcan::app
