#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "app/command_line/commands.h"
#include "app/command_line/row_files.h"
#include "app/stage/dataset_input.h"
#include "base/error.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "runs/export.h"
#include "storage/hdf5.h"

namespace hystcan::app {
namespace {

struct ExportArguments {
  std::filesystem::path run;
  std::filesystem::path output;
  runs::Selection selection;
  DatasetInput interval;
  bool csv = false, hdf5 = false;
};

std::uint64_t write_csv(const runs::Run& run, const ExportArguments& options) {
  OutputFile file(options.output);
  const std::uint64_t rows =
      runs::export_csv(run, options.selection, [&](std::string_view text) { file.write(text); });
  file.commit();
  return rows;
}

std::uint64_t write_hdf5(const runs::Run& run, const ExportArguments& options) {
  OutputFile file(options.output);
  storage::Hdf5Writer hdf5(file.written());
  const std::uint64_t rows = runs::export_hdf5(run, options.selection, hdf5);
  hdf5.close();
  file.commit();
  return rows;
}

int export_run(ExportArguments options) {
  options.selection.span = span_of(options.interval);
  const runs::Run run = open_run(options.run);
  if (options.hdf5 && options.output.empty())
    options.output = is_directory(options.run) ? run.name() + ".h5" : options.run.stem().string() + ".h5";
  if (options.output.empty())
    return print_for_reader([&] {
      runs::export_csv(run, options.selection, [](std::string_view text) { print(std::string(text)); });
      return done;
    });
  refuse_to_overwrite(options.output, options.run);
  const bool is_hdf5 = options.hdf5 || (!options.csv && has_hdf5_name(options.output));
  const std::uint64_t rows = is_hdf5 ? write_hdf5(run, options) : write_csv(run, options);
  note("{}: {}\n", options.output.string(), counted(rows, "row"));
  return done;
}

}  // namespace

void add_export(CLI::App& cli, int& status) {
  auto options = std::make_shared<ExportArguments>();
  CLI::App* command =
      cli.add_subcommand("export", "Write a recorded run or a part of it to one CSV or HDF5 file");
  command
      ->add_option("RUN", options->run,
                   "folder of a run, a CSV file in this folder, or any CSV file with one row per cycle")
      ->required();
  command->add_option("--output", options->output,
                      "output file: HDF5 if its name ends in .h5, else CSV; default: CSV to standard output");
  CLI::Option* csv = command->add_flag("--csv", options->csv, "write CSV for any file name");
  command
      ->add_flag("--hdf5", options->hdf5,
                 "write HDF5; default file: NAME-OF-THE-RUN.h5 in the working directory")
      ->excludes(csv);
  command->add_option("--axis", options->selection.axis,
                      "axis; default: the only axis, or all axes for HDF5");
  command->add_option("--signals", options->selection.signals, "columns besides time_s; default: all")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_interval_options(*command, options->interval);
  command->callback([options, &status] { status = export_run(*options); });
}

}  // namespace hystcan::app
