#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/command_line/commands.h"
#include "app/page/config_save.h"
#include "base/error.h"
#include "base/input_file.h"
#include "base/standard_streams.h"
#include "config/document/document.h"
#include "config/document/format.h"

namespace hystcan::app {
namespace {

struct MigrateArguments {
  std::vector<std::filesystem::path> files;
  bool write = false;
};

struct Migrated {
  std::filesystem::path file;
  std::string before;
  config::Migration migration;

  bool changes() const { return migration.text != before; }
};

std::string text_of(const std::filesystem::path& file) {
  try {
    return read_regular_file(file, config::largest_model_file);
  } catch (const FileError& error) {
    throw Error(fmt::format("{}: cannot be read: {}, expected a TOML file", file.string(), error.what()));
  }
}

Migrated migrated(const std::filesystem::path& file) {
  const std::string before = text_of(file);
  Migrated done{file, before, config::migrate(before, file.string())};
  (void)config::Document(file, done.migration.text).root();  // what is written can be read
  return done;
}

/// All files are looked at before the first is written.
int run_migrate(const MigrateArguments& options) {
  std::vector<Migrated> all;
  all.reserve(options.files.size());
  for (const std::filesystem::path& file : options.files) all.push_back(migrated(file));
  for (const Migrated& one : all) {
    if (!one.changes()) {
      print("{}: format {}, nothing to do\n", one.file.string(), one.migration.from);
      continue;
    }
    print("{}: from format {} to {}\n{}", one.file.string(), one.migration.from, config::newest_format,
          line_diff(one.before, one.migration.text));
    if (!options.write) continue;
    write_save(one.file, {.before = one.before, .text = one.migration.text, .diff = {}, .digest = {}});
    print("{}: written; the former file is {}\n", one.file.string(), kept_beside(one.file).string());
  }
  return done;
}

}  // namespace

void add_migrate(CLI::App& cli, int& status) {
  auto options = std::make_shared<MigrateArguments>();
  CLI::App* command = cli.add_subcommand(
      "migrate", "Show configurations, model files and memory files in the newest format, and write them");
  command->add_option("FILE", options->files, "TOML files")->required();
  command->add_flag("--write", options->write, "write them; each former file is kept as FILE.before-save");
  command->callback([options, &status] { status = run_migrate(*options); });
}

}  // namespace hystcan::app
