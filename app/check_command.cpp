#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "app/commands.h"
#include "config/config.h"

namespace hystcan::app {
namespace {

struct Options {
  std::filesystem::path config;
};

/// Nothing is moved and no interface is opened: a configuration is read, checked, and shown with what follows
/// from it.
int check(const Options& options) {
  const config::Config config = config::load(options.config);
  fmt::print("# {}, as in force\n{}\n", options.config.string(), config::echo(options.config));
  const double cycle_s = 1.0 / config.controller.rate_Hz;
  for (const config::AxisConfig& axis : config.axes) {
    const model::Hysteresis hysteresis(axis.control.law.model);
    const model::Interval reach = hysteresis.output_range();
    fmt::print("# axis {}: {} to {} {} reach {:.4g} to {:.4g} um; the reference is previewed by {:.4g} ms\n",
               axis.wire.name, hysteresis.input_range().lo, hysteresis.input_range().hi, axis.drive_unit,
               reach.lo, reach.hi, 1e3 * axis.control.delays.preview_s(cycle_s));
  }
  fmt::print("# {} messages in {}; node ids, identifiers, units and ranges agree\n",
             config.database.messages.size(), config.bus.dbc.string());
  return done;
}

}  // namespace

void add_check(CLI::App& cli, int& status) {
  auto options = std::make_shared<Options>();
  CLI::App* command = cli.add_subcommand("check", "Read and check a configuration; show what is in force");
  command->add_option("CONFIG", options->config, "configuration (TOML)")->required();
  command->callback([options, &status] { status = check(*options); });
}

}  // namespace hystcan::app
