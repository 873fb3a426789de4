#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <thread>

#include "app/command_line/commands.h"
#include "app/command_line/status_text.h"
#include "app/live/answer_json.h"
#include "app/live/control_client.h"
#include "app/live/control_protocol.h"
#include "app/live/socket_place.h"
#include "app/live/stop_signal.h"
#include "app/page/bus_counters.h"
#include "app/stage/option_check.h"
#include "base/standard_streams.h"
#include "base/terminal.h"

namespace hystcan::app {
namespace {

constexpr std::chrono::milliseconds answer_limit{1000};
constexpr std::chrono::milliseconds redraw_every{200};
constexpr std::chrono::milliseconds print_every{1000};

struct StatusArguments {
  std::string socket;
  std::string interface = "vcan0";
  bool shows_bus = true;  ///< false if the user gives only a socket, because a socket does not identify its
                          ///< CAN interface
  bool watch = false;
  bool json = false;
};

/// Returns the controller's answer to the command `status`. Throws RunError if the controller does not
/// answer.
nlohmann::json ask(const StatusArguments& options) {
  const std::filesystem::path file =
      options.socket.empty() ? find_socket(options.interface) : std::filesystem::path(options.socket);
  try {
    return ask_socket(file, command_of(Verb::status), answer_limit);
  } catch (const std::system_error& error) {
    throw RunError(
        file, error.code().message(),
        {.remedy = "check that the controller is running on this interface (--interface, --socket)"});
  }
}

void print_lines(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) print(line + "\n");
  flush_output();
}

/// Shows the status repeatedly until a signal or a key ends it. Continues to ask while no controller is
/// running.
int watch(const StatusArguments& options, const std::function<std::optional<BusReport>()>& bus) {
  const auto lines = [&] {
    try {
      return status_screen(read_answer<StatusAnswer>(ask(options)), bus(), "");
    } catch (const RunError& error) {
      return status_screen({}, bus(), fmt::format("no answer, trying again: {}", error.what()));
    }
  };
  stop_at_a_signal();
  std::optional<Screen> screen;
  if (::isatty(STDOUT_FILENO) == 1) screen.emplace();
  while (stop_signalled == 0 && !(screen && screen->quit())) {
    if (screen) {
      screen->show(lines());
    } else {
      print_lines(lines());
      print("\n");
    }
    std::this_thread::sleep_for(screen ? redraw_every : print_every);
  }
  return done;
}

int run_status(const StatusArguments& options) {
  BusCounters counters(options.interface, {});
  const auto bus = [&] { return options.shows_bus ? std::optional(counters.report()) : std::nullopt; };
  if (options.watch) return watch(options, bus);
  const nlohmann::json status = ask(options);
  if (options.json)
    print(status.dump(2) + "\n");
  else
    print_lines(status_screen(read_answer<StatusAnswer>(status), bus(), ""));
  return done;
}

}  // namespace

void add_status(CLI::App& cli, int& status) {
  auto options = std::make_shared<StatusArguments>();
  CLI::App* command =
      cli.add_subcommand("status", "Show axes, nodes, bus and timing of a running controller");
  command->add_option("--socket", options->socket, "file of the control socket");
  add_checked(*command, "--interface", options->interface, interface_name(),
              "CAN interface of the controller, if there is no --socket")
      ->capture_default_str();
  CLI::Option* watch = command->add_flag("--watch", options->watch, "update continuously until q or Ctrl-C");
  command->add_flag("--json", options->json, "print the answer as JSON")->excludes(watch);
  command->callback([options, command, &status] {
    options->shows_bus = command->count("--socket") == 0 || command->count("--interface") > 0;
    status = print_for_reader([&] { return run_status(*options); });
  });
}

}  // namespace hystcan::app
