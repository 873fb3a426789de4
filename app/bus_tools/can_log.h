// A log of candump as input, and the database to read it with.
#pragma once

#include <filesystem>
#include <fstream>

#include "can/dbc/database.h"

namespace hystcan::app {

/// Throws config::Error where it can't be read.
std::ifstream open_can_log(const std::filesystem::path& path);

/// Says on standard error what is odd in a DBC, of much only the beginning.
void print_parse_warnings(const can::Database& database);

}  // namespace hystcan::app
