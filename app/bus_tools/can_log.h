// Opens a candump log as input, and prints the warnings of the database that decodes it.
#pragma once

#include <filesystem>
#include <istream>
#include <memory>

#include "can/dbc/database.h"

namespace hystcan::app {

/// Throws config::Error if the log cannot be read. It may be a pipe.
std::unique_ptr<std::istream> open_can_log(const std::filesystem::path& path);

/// Prints the warnings of a DBC on standard error, at most the first ten.
void print_parse_warnings(const can::Database& database);

}  // namespace hystcan::app
