#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "app/commands/commands.h"
#include "app/io/dataset_input.h"
#include "app/io/output_file.h"
#include "app/io/standard_streams.h"
#include "can/counted.h"
#include "config/document/error.h"
#include "runs/export.h"

namespace hystcan::app {
namespace {

struct ExportArguments {
  std::filesystem::path run;
  std::filesystem::path output;
  runs::Selection selection;
  DatasetInput interval;
};

runs::TimeSpan span_of(const DatasetInput& interval) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const runs::TimeSpan span{interval.from_s.value_or(-infinity), interval.to_s.value_or(infinity)};
  if (span.from_s > span.to_s)
    throw config::Error(fmt::format("--from is {}, expected at most --to, {}", span.from_s, span.to_s));
  return span;
}

int export_run(ExportArguments options) {
  options.selection.span = span_of(options.interval);
  const runs::Run run(options.run);
  if (options.output.empty())
    return print_for_reader([&] {
      runs::export_csv(run, options.selection, [](std::string_view text) { print(std::string(text)); });
      return done;
    });
  OutputFile file(options.output);
  const std::uint64_t rows =
      runs::export_csv(run, options.selection, [&](std::string_view text) { file.write(text); });
  file.commit();
  note("{}: {}\n", options.output.string(), can::counted(rows, "row"));
  return done;
}

}  // namespace

void add_export(CLI::App& cli, int& status) {
  auto options = std::make_shared<ExportArguments>();
  CLI::App* command = cli.add_subcommand("export", "Write a recorded run, or a part of it, as one CSV");
  command->add_option("RUN", options->run, "folder of a run, or a CSV of cycles")->required();
  command->add_option("--output", options->output, "file to write; standard output if left out");
  command->add_option("--axis", options->selection.axis, "may be left out if the run has one axis");
  command->add_option("--signals", options->selection.signals, "columns beside time_s; all if left out")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_interval_options(*command, options->interval);
  command->callback([options, &status] { status = export_run(*options); });
}

}  // namespace hystcan::app
