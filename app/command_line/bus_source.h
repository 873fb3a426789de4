// Finds the input of commands that read CAN frames. One kind of input is a CAN interface with a database
// (DBC); both are named in a configuration or in options. The second kind is a file recorded with candump.
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

/// Adds the arguments [CONFIG] [--interface IF] [--dbc FILE] to `command`. An option replaces the value of
/// the configuration.
void add_bus_options(CLI::App& command, BusOptions& options);

struct BusSource {
  std::string interface;
  std::optional<can::Database> database;
  can::Protections protections;  ///< CRC and counter fields of the configured messages, to check frames;
                                 ///< empty with --dbc
};

/// Returns interface and database. Throws Error if no interface is given, or if a file cannot be read or is
/// invalid.
BusSource find_bus(const BusOptions& options);

/// The expected file format, as text for the errors of open_input().
inline constexpr const char* a_candump_log = "a log of candump -L";
/// The message printed if the last line of a log may be incomplete, for example after a crash.
inline constexpr const char* last_line_left_out =
    "ignoring the last line: it has no line end and may be incomplete";
/// Throws Error if the log `name` contained no frames. Such a file is not a candump log, or nothing was
/// recorded.
void require_frames(const std::string& name, std::uint64_t frames);

/// Prints at most the first ten warnings of a DBC on standard error.
void print_parse_warnings(const can::Database& database);

}  // namespace hystcan::app
