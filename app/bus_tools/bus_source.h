// Which bus to listen to and what its messages mean: named by a configuration, or one by one.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "can/dbc/database.h"
#include "can/protocol/e2e.h"

namespace hystcan::app {

struct BusOptions {
  std::filesystem::path config;
  std::string interface;
  std::filesystem::path dbc;
};

/// [CONFIG] [--interface IF] [--dbc FILE]: the last two go before what the configuration says.
void add_bus_options(CLI::App& command, BusOptions& options);

struct BusSource {
  std::string interface;
  std::optional<can::Database> database;
  can::Protections protections;  ///< of the configuration's own messages; none with --dbc, which has others
};

/// Throws config::Error where no interface is named; what reading the files throws.
BusSource find_bus(const BusOptions& options);

/// A duration in seconds on the command line.
CLI::Validator positive_seconds();

/// Writes to standard output. Throws RunError where that fails, as on a full disk.
void print(std::string_view text);
void flush_output();

}  // namespace hystcan::app
