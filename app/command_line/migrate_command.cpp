#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/command_line/commands.h"
#include "app/page/config_save.h"
#include "base/error.h"
#include "base/standard_streams.h"
#include "config/document/document.h"
#include "config/document/format.h"
#include "config/document/toml_edit.h"

namespace hystcan::app {
namespace {

struct MigrateArguments {
  std::vector<std::filesystem::path> files;
  bool write = false;
};

struct Migrated {
  std::filesystem::path file;
  int from = config::newest_format;
  ConfigSave save;
};

Migrated migrated(const std::filesystem::path& file) {
  const std::string before = config::TomlEdit::of_file(file, config::largest_model_file).text();
  const config::Migration migration = config::migrate(before, file.string());
  (void)config::Document(file, migration.text).root();  // what is written can be read
  return {file, migration.from, config_save(before, migration.text)};
}

/// All files are looked at before the first is written.
int run_migrate(const MigrateArguments& options) {
  std::vector<Migrated> all;
  all.reserve(options.files.size());
  for (const std::filesystem::path& file : options.files) all.push_back(migrated(file));
  for (const auto& [file, from, save] : all) {
    if (save.diff.empty()) {
      print("{}: format {}, nothing to do\n", file.string(), from);
      continue;
    }
    print("{}: from format {} to {}\n{}", file.string(), from, config::newest_format, save.diff);
    if (!options.write) continue;
    write_save(file, save);
    print("{}: written; the former file is {}\n", file.string(), kept_beside(file).string());
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
