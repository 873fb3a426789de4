// The CAN interface to listen to and the database of its messages, from a configuration or from options.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "can/dbc/database.h"
#include "can/protocol/e2e.h"

namespace CLI {
class App;
}  // namespace CLI

namespace hystcan::app {

struct BusOptions {
  std::filesystem::path config;
  std::string interface;
  std::filesystem::path dbc;
};

/// [CONFIG] [--interface IF] [--dbc FILE]. The options override the configuration.
void add_bus_options(CLI::App& command, BusOptions& options);

struct BusSource {
  std::string interface;
  std::optional<can::Database> database;
  can::Protections protections;  ///< of the configuration's messages; empty with --dbc
};

/// Throws Error if no interface is named, and the errors of the files that it reads.
BusSource find_bus(const BusOptions& options);

}  // namespace hystcan::app
