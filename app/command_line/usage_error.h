// The message of a command line that cannot be used.
#pragma once

#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace hystcan::app {

/// One line that begins with the command: `hystcan identify: --order: 0, expected auto or 1 to 20`. A command or an
/// option that does not exist is named with the nearest that does.
std::string usage_error(const CLI::App& cli, const CLI::ParseError& error);

}  // namespace hystcan::app
