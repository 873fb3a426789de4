#include "app/command_line/bus_source.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <utility>

#include "app/stage/option_check.h"
#include "base/standard_streams.h"
#include "config/schema/config.h"
#include "config/schema/frames.h"

namespace hystcan::app {

void add_bus_options(CLI::App& command, BusOptions& options) {
  command.add_option("CONFIG", options.config, "configuration (TOML) that names interface and DBC");
  add_checked(command, "--interface", options.interface, interface_name(),
              "CAN interface; default: as configured");
  command.add_option("--dbc", options.dbc, "CAN database (DBC); default: as configured");
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
  if (source.interface.empty())
    throw Error("the CAN interface is missing", expect("a configuration or --interface"));
  return source;
}

void require_frames(const std::string& name, std::uint64_t frames) {
  if (frames == 0) throw Error(name, "no frames", {.expected = a_candump_log});
}

void print_parse_warnings(const can::Database& database) {
  constexpr std::size_t printed_max = 10;
  const std::size_t printed = std::min(printed_max, database.warnings.size());
  for (std::size_t i = 0; i < printed; ++i) note("warning: {}\n", database.warnings[i]);
  const std::size_t more = database.warnings.size() - printed + database.further_warnings;
  if (more > 0) note("warning: and {} more\n", more);
}

}  // namespace hystcan::app
