#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line/bus_source.h"
#include "app/command_line/commands.h"
#include "app/command_line/monitor_table.h"
#include "app/live/stop_signal.h"
#include "app/stage/option_check.h"
#include "base/standard_streams.h"
#include "base/terminal.h"
#include "can/log/traffic.h"
#include "can/socketcan/bus_monitor.h"
#include "can/socketcan/interface.h"

namespace hystcan::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds poll_interval{50};  // of keys and signals

struct MonitorArguments {
  BusOptions bus;
  double period_s = 1.0;
  bool once = false;
  bool json = false;
};

std::chrono::microseconds time_of_day() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::system_clock::now().time_since_epoch());
}

BusLine bus_line(const std::string& interface, const can::BusMonitor& tap, const can::Traffic& traffic,
                 can::BusState at_start) {
  return {interface, tap.up(), traffic.state().value_or(at_start), tap.lost(), time_of_day()};
}

void show_plainly(const BusLine& bus, const can::Traffic& traffic, bool json, bool first) {
  if (json) {
    print(monitor_json(bus, traffic));
  } else {
    if (!first) print("\n");
    for (const std::string& line : monitor_lines(bus, traffic)) print(line + '\n');
  }
  flush_output();
}

int run_monitor(const MonitorArguments& options) {
  const BusSource source = find_bus(options.bus);
  const can::Database nothing;
  can::Traffic traffic(source.database ? *source.database : nothing, source.protections);
  const can::BusState at_start =
      can::require_can_interface(source.interface).bus_state.value_or(can::BusState::active);
  can::BusMonitor tap(source.interface);
  stop_at_a_signal();
  std::optional<Screen> screen;
  if (!options.json && !options.once && ::isatty(STDOUT_FILENO) == 1) screen.emplace();

  const can::BusMonitor::Handler add = [&](const can::LoggedFrame& logged) { traffic.add(logged); };
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options.period_s));
  auto began = Clock::now();
  bool first = true;
  while (stop_signalled == 0 && !(screen && screen->quit())) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(began + period - Clock::now());
    tap.listen(std::clamp(left, std::chrono::milliseconds{0}, poll_interval), add);
    const auto now = Clock::now();
    if (now - began < period) continue;
    traffic.end_period(now - began);
    began = now;
    const BusLine bus = bus_line(source.interface, tap, traffic, at_start);
    if (screen)
      screen->show(monitor_lines(bus, traffic));
    else
      show_plainly(bus, traffic, options.json, first);
    first = false;
    if (options.once) break;
  }
  return done;
}

}  // namespace

void add_monitor(CLI::App& cli, int& status) {
  auto options = std::make_shared<MonitorArguments>();
  CLI::App* command = cli.add_subcommand("monitor", "Show the traffic on the bus, one row per message");
  add_bus_options(*command, options->bus);
  command
      ->add_option("--period", options->period_s, "seconds between tables, also the window of the rates; 1")
      ->check(positive_seconds());
  command->add_flag("--once", options->once, "one table after one period");
  command->add_flag("--json", options->json, "a JSON object in one line for each table");
  command->callback([options, &status] { status = print_for_reader([&] { return run_monitor(*options); }); });
}

}  // namespace hystcan::app
