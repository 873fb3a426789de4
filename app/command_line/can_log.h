// Opens a candump log as input, and prints the warnings of the database that decodes it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <memory>
#include <string>

#include "can/dbc/database.h"

namespace hystcan::app {

/// Throws Error if the log cannot be read. It may be a pipe.
std::unique_ptr<std::istream> open_can_log(const std::filesystem::path& path);

/// Throws Error if a log had no frames, which is then no log or a recording of nothing.
void require_frames(const std::string& name, std::uint64_t frames);

/// Prints the warnings of a DBC on standard error, at most the first ten.
void print_parse_warnings(const can::Database& database);

}  // namespace hystcan::app
