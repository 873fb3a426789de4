#include "app/command_line/bus_source.h"

#include <CLI/CLI.hpp>
#include <utility>

#include "app/command_line/can_log.h"
#include "app/stage/option_check.h"
#include "config/schema/config.h"
#include "config/schema/frames.h"

namespace hystcan::app {

void add_bus_options(CLI::App& command, BusOptions& options) {
  command.add_option("CONFIG", options.config, "configuration (TOML) that names interface and DBC");
  command.add_option("--interface", options.interface, "CAN interface instead of the configured one")
      ->check(interface_name());
  command.add_option("--dbc", options.dbc, "CAN database (DBC) instead of the configured one");
}

BusSource find_bus(const BusOptions& options) {
  BusSource source;
  if (!options.config.empty()) {
    config::Config config = config::load(options.config);
    source.interface = config.bus.interface;
    if (options.dbc.empty())
      for (const config::AxisConfig& axis : config.axes)
        source.protections.merge(config::protections(axis.wire, config.database));
    source.database = std::move(config.database);
  }
  if (!options.interface.empty()) source.interface = options.interface;
  if (!options.dbc.empty()) source.database = can::load_dbc(options.dbc);
  if (source.database) print_parse_warnings(*source.database);
  if (source.interface.empty()) throw Error("no interface is named, expected a configuration or --interface");
  return source;
}

}  // namespace hystcan::app
