// The input of the bus commands: the interface and the database of its messages, from a configuration or from
// options; or a candump log.
#pragma once

#include <cstdint>
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

/// Adds [CONFIG] [--interface IF] [--dbc FILE]. The options override the configuration.
void add_bus_options(CLI::App& command, BusOptions& options);

struct BusSource {
  std::string interface;
  std::optional<can::Database> database;
  can::Protections protections;  ///< protection of the configuration's messages; empty with --dbc
};

/// Throws Error if no interface is given, and the errors of the files that it reads.
BusSource find_bus(const BusOptions& options);

/// The expected content in the errors of open_input().
inline constexpr const char* a_candump_log = "a log of candump -L";
/// The note about a log whose last line may be incomplete, for example after a crash.
inline constexpr const char* last_line_left_out =
    "ignoring the last line: it has no line end and may be incomplete";
/// Throws Error if a log had no frames: it is not a candump log, or nothing was recorded.
void require_frames(const std::string& name, std::uint64_t frames);

/// Prints at most the first ten warnings of a DBC on standard error.
void print_parse_warnings(const can::Database& database);

}  // namespace hystcan::app
