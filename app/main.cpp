#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>

#include "app/command_line/commands.h"
#include "base/error.h"
#include "base/log_sink.h"
#include "base/standard_streams.h"
#include "config/schema/config.h"

namespace {

using namespace hystcan;

/// Prints a line on standard error and returns `status`. Does not throw if standard error is closed, and
/// waits at most 1 s for a reader that does not read.
int print_line(const std::string& text, int status) {
  const std::string line = printable(text) + "\n";
  spdlog::default_logger()->flush();
  std::string_view rest = line;
  write_within(STDERR_FILENO, rest, std::chrono::seconds(1));
  return status;
}

/// Prints the error as one line and returns `status`. Line ends, which file names may contain, become spaces.
int print_error(std::string reason, int status) {
  std::ranges::replace(reason, '\n', ' ');
  return print_line(fmt::format("hystcan: {}", reason), status);
}

int print_error(const std::exception& error, int status) { return print_error(error_text(error), status); }

int run(int argc, char** argv) {
  CLI::App cli("Controller for smart-material actuators on a CAN bus, with a simulation twin");
  cli.name("hystcan");
  cli.set_version_flag("--version", HYSTCAN_VERSION);
  cli.require_subcommand(1);
  int status = done;
  app::add_commands(cli, status);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) return print_line(app::usage_error(cli, error), bad_input);
    std::ostringstream help_text, ignored;
    cli.exit(error, help_text, ignored);  // prints the text of --help or --version
    return print_for_reader([&] {
      print(help_text.str());
      return done;
    });
  }
  return status;
}

/// Runs the command and returns its exit status. If the command throws, prints the error and returns the
/// matching exit status.
template <class Command>
int report_errors(const Command& command) {
  try {
    return command();
  } catch (const Error& error) {
    return print_error(error, bad_input);
  } catch (const std::invalid_argument& error) {
    return print_error(error, bad_input);
  } catch (const std::system_error& error) {
    if (!is_lost_output()) return print_error(error, failed);
    return print_error(lost_output_text(error.code().message()), failed);
  } catch (const std::exception& error) {  // for example RunError, or a full disk
    return print_error(error, failed);
  }
}

}  // namespace

int main(int argc, char** argv) {
  prepare_standard_streams();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("hystcan", std::make_shared<LogSink>(STDERR_FILENO)));
  const int status = report_errors([&] { return run(argc, argv); });
  const int printed = report_errors([] {
    flush_output();
    return done;
  });
  return status == done ? printed : status;
}
