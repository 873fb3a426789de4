// The subcommands of `hystcan`. Each one parses its arguments, calls the libraries in the other folders, and
// sets the exit status.
#pragma once

#include <string>

#include "base/error.h"

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace hystcan::app {

/// Adds all subcommands to `cli`, with the examples of their --help. The subcommand that runs stores its exit
/// status in `status`.
void add_commands(CLI::App& cli, int& status);
/// Returns the message for an invalid command line. It is one line that begins with the command, such as
/// `hystcan identify: --order: 0, expected auto or 1 to 20`. For an unknown command or option, the message
/// also suggests the most similar valid word.
std::string usage_error(const CLI::App& cli, const CLI::ParseError& error);
/// Adds the examples to the end of the --help text of every command below `cli`.
void add_examples(CLI::App& cli);

/// Adds one subcommand to `cli`. If the user's command line selects it, it runs once and stores its exit
/// status in `status`.
using AddCommand = void (*)(CLI::App& cli, int& status);

void add_check(CLI::App& cli, int& status);
void add_completion(CLI::App& cli, int& status);
void add_controller(CLI::App& cli, int& status);
void add_ctl(CLI::App& cli, int& status);
void add_decode(CLI::App& cli, int& status);
void add_demo(CLI::App& cli, int& status);
void add_doctor(CLI::App& cli, int& status);
void add_excite(CLI::App& cli, int& status);
void add_export(CLI::App& cli, int& status);
void add_identify(CLI::App& cli, int& status);
void add_init(CLI::App& cli, int& status);
void add_monitor(CLI::App& cli, int& status);
void add_node(CLI::App& cli, int& status);
void add_page(CLI::App& cli, int& status);
void add_plot(CLI::App& cli, int& status);
void add_runs(CLI::App& cli, int& status);
void add_simulate(CLI::App& cli, int& status);
void add_status(CLI::App& cli, int& status);
void add_tune(CLI::App& cli, int& status);
void add_twin(CLI::App& cli, int& status);
void add_validate(CLI::App& cli, int& status);

}  // namespace hystcan::app
