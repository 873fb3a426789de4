#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line/bus_source.h"
#include "app/command_line/commands.h"
#include "app/command_line/frame_text.h"
#include "app/live/stop_signal.h"
#include "app/stage/option_check.h"
#include "base/standard_streams.h"
#include "base/terminal.h"
#include "base/text.h"
#include "can/dbc/message_decoder.h"
#include "can/log/traffic.h"
#include "can/socketcan/bus_monitor.h"
#include "can/socketcan/interface.h"

namespace hystcan::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds poll_interval{50};  // longest delay of the reaction to a key or a signal

struct MonitorArguments {
  BusOptions bus;
  double period_s = 1.0;
  bool once = false;
  bool json = false;
};

struct BusLine {
  std::string interface;
  can::BusState state = can::BusState::active;
  std::uint64_t lost = 0;           ///< frames that the kernel dropped
  std::chrono::microseconds now{};  ///< time since 1970-01-01 UTC, from which the ages of the messages are
                                    ///< computed
};

using can::MessageTraffic;
using can::Traffic;

std::string_view name_of(const MessageTraffic& traffic) {
  return traffic.message != nullptr ? std::string_view(traffic.message->name) : "(unknown)";
}

can::Rejection rejection(std::size_t index) { return static_cast<can::Rejection>(index); }

std::string rejects_text(const MessageTraffic& traffic) {
  std::string text;
  for (std::size_t i = 0; i < can::rejection_count; ++i)
    if (traffic.rejected[i] > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", traffic.rejected[i], to_string(rejection(i)));
  return text.empty() ? text : " [rejected: " + text + ']';
}

std::string content(const MessageTraffic& traffic) {
  if (!traffic.newest) return {};
  const can::LoggedFrame& newest = *traffic.newest;
  if (traffic.message == nullptr) {
    const std::string text = can::candump_frame(newest.frame);
    return text.substr(text.find('#') + 1);
  }
  return signals_text(can::decode_signals(*traffic.message, newest.frame));
}

double age_ms(const BusLine& bus, const MessageTraffic& traffic) {
  return std::max(0.0, std::chrono::duration<double, std::milli>(bus.now - traffic.last).count());
}

std::string row(const Traffic::Key& key, const MessageTraffic& traffic, const BusLine& bus,
                std::size_t width) {
  const std::string jitter = traffic.jitter_ms ? fmt::format("{:.3f}", *traffic.jitter_ms) : "-";
  const std::string age = traffic.newest ? fmt::format("{:.0f}", age_ms(bus, traffic)) : "-";
  return fmt::format("{:<{}} {:>8} {:>9} {:>9.1f} {:>9} {:>8}  {}{}", name_of(traffic), width,
                     id_text(key.second, key.first), traffic.count, traffic.rate_Hz, jitter, age,
                     content(traffic), rejects_text(traffic));
}

/// Returns the lines of the screen: the state of the bus, a heading, then one row for each message. Rows may
/// be wider than the terminal.
std::vector<std::string> monitor_lines(const BusLine& bus, const Traffic& traffic) {
  std::string top = fmt::format("{}: {}", bus.interface, to_string(bus.state));
  if (const auto counters = traffic.error_counters())
    top += fmt::format(", error counters transmit {} receive {}", counters->transmit, counters->receive);
  top +=
      fmt::format(", {:.1f} frames/s, {}, {}, {} lost", traffic.rate_Hz(), counted(traffic.frames(), "frame"),
                  counted(traffic.error_frames(), "error frame"), bus.lost);
  std::size_t width = 12;
  for (const auto& [key, of_message] : traffic.messages())
    width = std::max(width, name_of(of_message).size());
  std::vector<std::string> lines{
      top, fmt::format("{:<{}} {:>8} {:>9} {:>9} {:>9} {:>8}  {}", "message", width, "id", "count", "rate/Hz",
                       "jitter/ms", "age/ms", "signals")};
  lines.reserve(lines.size() + traffic.messages().size());
  for (const auto& [key, of_message] : traffic.messages()) lines.push_back(row(key, of_message, bus, width));
  return lines;
}

/// Returns the state of the bus and all messages as one JSON object, in one line.
std::string monitor_json(const BusLine& bus, const Traffic& traffic) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, R"({{"interface":{},"state":"{}","error_counters":)", json_string(bus.interface),
                 to_string(bus.state));
  if (const auto counters = traffic.error_counters())
    fmt::format_to(out, R"({{"transmit":{},"receive":{}}})", counters->transmit, counters->receive);
  else
    text += "null";
  fmt::format_to(out, R"(,"rate_Hz":{},"frames":{},"error_frames":{},"lost":{},"messages":[)",
                 json_number(traffic.rate_Hz()), traffic.frames(), traffic.error_frames(), bus.lost);
  const char* between = "";
  for (const auto& [key, of_message] : traffic.messages()) {
    fmt::format_to(out, R"({}{{"message":{},"id":{},"extended":{},"count":{},"rate_Hz":{},"jitter_ms":{})",
                   between, of_message.message ? json_string(of_message.message->name) : std::string("null"),
                   key.second, key.first, of_message.count, json_number(of_message.rate_Hz),
                   of_message.jitter_ms ? json_number(*of_message.jitter_ms) : std::string("null"));
    if (of_message.newest) text += fd_flags_json(of_message.newest->frame);
    fmt::format_to(out, R"(,"age_ms":{},"rejected":{{)",
                   of_message.newest ? json_number(age_ms(bus, of_message)) : std::string("null"));
    for (std::size_t i = 0; i < can::rejection_count; ++i)
      fmt::format_to(out, R"({}"{}":{})", i == 0 ? "" : ",", to_string(rejection(i)), of_message.rejected[i]);
    text += R"(},"signals":)";
    text += signals_json(of_message.message != nullptr && of_message.newest
                             ? can::decode_signals(*of_message.message, of_message.newest->frame)
                             : std::vector<can::DecodedSignal>());
    text += '}';
    between = ",";
  }
  return text + "]}\n";
}

std::chrono::microseconds time_of_day() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::system_clock::now().time_since_epoch());
}

BusLine bus_line(const std::string& interface, const can::BusMonitor& tap, const can::Traffic& traffic,
                 can::BusState at_start) {
  return {interface, tap.up() ? traffic.state().value_or(at_start) : can::BusState::down, tap.lost(),
          time_of_day()};
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
  add_checked(*command, "--period", options->period_s, positive_seconds(),
              "seconds between tables, over which each table averages the rates; default: 1");
  command->add_flag("--once", options->once, "print one table after one period, then end");
  command->add_flag("--json", options->json, "print one JSON object per table, each in one line");
  command->callback([options, &status] { status = print_for_reader([&] { return run_monitor(*options); }); });
}

}  // namespace hystcan::app
