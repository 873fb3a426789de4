#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line/commands.h"
#include "app/command_line/run_figures.h"
#include "app/command_line/run_plots.h"
#include "app/stage/dataset_input.h"
#include "app/stage/option_check.h"
#include "base/error.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "runs/export.h"

namespace hystcan::app {
namespace {

struct PlotArguments {
  std::vector<std::filesystem::path> runs;
  RunPlots plots{.folder = "hystcan-plots", .kinds = {}, .formats = {}, .size = {}};
  std::string axis;
  std::string table;
  DatasetInput interval;
};

/// Returns a unique name for the run in the plots. If another run has the same name, such as average.csv in
/// two folders, the folder's name is put before it.
std::string distinct_name(const std::vector<RunFigures>& others, const runs::Run& run) {
  std::string name = std::filesystem::is_directory(run.path()) ? run.name() : run.path().stem().string();
  for (const RunFigures& other : others)
    if (other.run == name)
      return std::filesystem::absolute(run.path()).parent_path().filename().string() + "-" + name;
  return name;
}

std::vector<RunFigures> read_all(const PlotArguments& options) {
  const runs::TimeSpan span = span_of(options.interval);
  std::vector<RunFigures> all;
  for (const std::filesystem::path& path : options.runs) {
    const runs::Run run = open_run(path);
    const std::string name = distinct_name(all, run);
    runs::Selection selection;
    if (!options.axis.empty()) selection.axis = options.axis;
    for (const std::size_t axis : runs::axes_of(run, selection)) {
      all.push_back(figures_of(run, axis, span));
      all.back().run = name;
    }
  }
  return all;
}

int run_plot(PlotArguments options) {
  RunPlots& plots = options.plots;
  if (plots.kinds.empty()) plots.kinds = plot_kinds();
  if (plots.formats.empty()) plots.formats = picture_formats();
  const std::vector<RunFigures> runs = read_all(options);
  if (!options.table.empty()) print(run_table(runs, options.table));
  create_folder(plots.folder);
  const DrawnPlots drawn = draw_runs(runs, plots);
  for (const std::string& lacking : drawn.lacking) note("{}\n", lacking);
  if (drawn.undrawn)
    throw RunError(plots.folder, fmt::format("no pictures: {}", *drawn.undrawn),
                   {.remedy = "the data files (.csv) are complete"});
  for (const std::string& name : drawn.names)
    note("{}: {}\n", (plots.folder / name).string(), fmt::join(plots.formats, ", "));
  return done;
}

}  // namespace

void add_plot(CLI::App& cli, int& status) {
  auto options = std::make_shared<PlotArguments>();
  CLI::App* command = cli.add_subcommand("plot", "Draw recorded runs for the lab book and for print");
  command->add_option("RUN", options->runs, "folders of runs, or CSVs of cycles (controller --csv, demo)")
      ->required();
  command->add_option("--kind", options->plots.kinds, "pictures to draw, separated by commas; default: all")
      ->delimiter(',')
      ->check(one_of(plot_kinds()))
      ->allow_extra_args(false);
  command->add_option("--output", options->plots.folder, "folder of the pictures")->capture_default_str();
  command->add_option("--format", options->plots.formats, "file formats, separated by commas; default: all")
      ->delimiter(',')
      ->check(one_of(picture_formats()))
      ->allow_extra_args(false);
  command->add_option("--axis", options->axis, "axis; default: all");
  add_checked(*command, "--table", options->table, one_of(table_formats()), "print the errors as a table");
  add_checked(*command, "--width", options->plots.size.width_mm, number_between(40, 1000), "mm")
      ->capture_default_str();
  add_checked(*command, "--height", options->plots.size.height_mm, number_between(30, 1000), "mm")
      ->capture_default_str();
  add_interval_options(*command, options->interval);
  command->callback([options, &status] { status = print_for_reader([&] { return run_plot(*options); }); });
}

}  // namespace hystcan::app
