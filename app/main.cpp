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

#include "app/commands/commands.h"
#include "app/io/bounded_output.h"
#include "app/io/error_text.h"
#include "app/io/standard_streams.h"
#include "app/io/usage_error.h"
#include "app/live/log_sink.h"
#include "can/dbc/database.h"
#include "can/log/candump.h"
#include "can/socketcan/socketcan_bus.h"
#include "config/schema/config.h"

namespace {

using namespace hystcan;

/// Prints a line on standard error. It neither throws if standard error is closed, as with the terminal, nor waits
/// forever for its reader.
int print_line(const std::string& text, int status) {
  const std::string line = app::printable(text) + "\n";
  spdlog::default_logger()->flush();
  std::string_view rest = line;
  app::write_within(STDERR_FILENO, rest, std::chrono::seconds(1));
  return status;
}

/// In one line, whatever the name of a file is.
int print_error(std::string reason, int status) {
  std::ranges::replace(reason, '\n', ' ');
  return print_line(fmt::format("hystcan: {}", reason), status);
}

int print_error(const std::exception& error, int status) {
  return print_error(app::error_text(error), status);
}

int run(int argc, char** argv) {
  CLI::App cli("Controller for smart-material actuators on a CAN bus, with a simulation twin");
  cli.name("hystcan");
  cli.set_version_flag("--version", HYSTCAN_VERSION);
  cli.require_subcommand(1);
  int status = app::done;
  app::add_commands(cli, status);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) return print_line(app::usage_error(cli, error), app::bad_input);
    std::ostringstream asked, ignored;
    cli.exit(error, asked, ignored);  // --help, --version
    return app::print_for_reader([&] {
      app::print(asked.str());
      return app::done;
    });
  }
  return status;
}

/// Returns the exit status of the command. Prints what it throws.
template <class Command>
int report_errors(const Command& command) {
  try {
    return command();
  } catch (const config::Error& error) {
    return print_error(error, app::bad_input);
  } catch (const can::DbcError& error) {
    return print_error(error, app::bad_input);
  } catch (const can::CandumpError& error) {
    return print_error(error, app::bad_input);
  } catch (const std::invalid_argument& error) {
    return print_error(error, app::bad_input);
  } catch (const std::system_error& error) {
    if (!app::is_lost_output()) return print_error(error, app::failed);
    return print_error(app::lost_output_text(error.code().message()), app::failed);
  } catch (const std::exception& error) {  // InterfaceError, RunError, a full disk
    return print_error(error, app::failed);
  }
}

}  // namespace

int main(int argc, char** argv) {
  app::prepare_standard_streams();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("hystcan", std::make_shared<app::LogSink>(STDERR_FILENO)));
  const int status = report_errors([&] { return run(argc, argv); });
  const int printed = report_errors([] {
    app::flush_output();
    return app::done;
  });
  return status == app::done ? printed : status;
}
