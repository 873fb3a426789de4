#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "app/command_line/commands.h"
#include "app/command_line/status_text.h"
#include "app/live/answer_json.h"
#include "app/live/control_client.h"
#include "app/live/socket_place.h"
#include "app/stage/option_check.h"
#include "base/error.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "twin/fault.h"

namespace hystcan::app {
namespace {

struct CtlArguments {
  std::string socket;
  std::string interface = "vcan0";
  bool json = false;
  double answer_timeout_s = 5.0;
  bool twin = false;
  nlohmann::json command = nlohmann::json::object();
};

/// Sends one command to the control socket `file` and returns the answer. `process` is "controller" or
/// "twin", the word for error messages.
nlohmann::json exchange(const std::filesystem::path& file, const nlohmann::json& command, const char* process,
                        std::optional<std::chrono::milliseconds> limit) {
  try {
    return ask_socket(file, command, limit);
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::timed_out)
      throw RunError(file, fmt::format("no answer within {:g} s (--timeout); the {} does not read its socket",
                                       std::chrono::duration<double>(*limit).count(), process));
    throw RunError(
        file, error.code().message(),
        {.remedy = fmt::format(
             "check that the {} is running on this interface (--interface, --socket, control_socket)",
             process)});
  }
}

/// Returns the time limit for the answer. The command `wait` adds its own timeout_s to the limit; `wait`
/// without timeout_s has no limit.
std::optional<std::chrono::milliseconds> limit_of(const CtlArguments& options, Verb verb) {
  const double timeout_s = options.command.value("timeout_s", 0.0);
  if (verb == Verb::wait && timeout_s <= 0.0) return std::nullopt;
  const double limit_s = options.answer_timeout_s + timeout_s;
  return std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double>(limit_s));
}

void print_answer(const TwinStatusAnswer& status) {
  print("{:.1f} s\n", status.time_s);
  print("{:<8} {:<10} {:<16} {:>10} {:>12}\n", "axis", "amplifier", "sensor", "drive", "position um");
  for (const TwinAxisAnswer& axis : status.axes)
    print("{:<8} {:<10} {:<16} {:>10} {:>12}\n", axis.name, axis.amplifier, axis.sensor,
          four_decimals(axis.drive), four_decimals(axis.position_um));
  for (const TwinFaultAnswer& fault : status.faults) {
    std::string line = fmt::format("{} of {}: {}", fault.node ? to_string(*fault.node) : "stage", fault.axis,
                                   to_string(fault.kind));
    if (fault.value) line += fmt::format(" {:g}", *fault.value);
    line += fmt::format(", since {:.3f} s", fault.began_s);
    if (fault.ends_s) line += fmt::format(" until {:.3f} s", *fault.ends_s);
    print("{}\n", line);
  }
}

void print_answer(const std::vector<config::Change>& changes) {
  for (const config::Change& change : changes) print("{}: {} -> {}\n", change.path, change.from, change.to);
}
void print_answer(const ChangesAnswer& answer) { print_answer(answer.changed); }
void print_answer(const SettingsAnswer& answer) { print_answer(answer.unsaved); }

void print_answer(const StatusAnswer& status) {
  for (const std::string& line : status_lines(status)) print("{}\n", line);
}
void print_answer(const FaultAnswer& answer) { print("{}\n", answer.fault); }
void print_answer(const RunAnswer& answer) { print("{}\n", answer.run); }
void print_answer(const RemovedAnswer& answer) { print("{} removed\n", counted(answer.removed, "fault")); }
void print_answer(const PositionAnswer& answer) { print("in position at {:.4f} um\n", answer.position_um); }
void print_answer(const DoneAnswer& answer) {
  for (const std::string& line : answer.nothing_to_do) print("{}\n", line);
}

int run(const CtlArguments& options, const ControlCommand& row) {
  const Server server = options.twin || row.controller == Reply::none ? Server::twin : Server::controller;
  const bool to_twin = server == Server::twin;
  const std::filesystem::path file = !options.socket.empty() ? std::filesystem::path(options.socket)
                                     : to_twin               ? find_twin_socket(options.interface)
                                                             : find_socket(options.interface);
  const nlohmann::json answer =
      exchange(file, options.command, to_twin ? "twin" : "controller", limit_of(options, row.verb));
  if (options.json) print("{}\n", answer.dump(2));
  with_answer(row.reply_of(server), [&](auto kind) {
    const auto read = read_answer<decltype(kind)>(answer);
    if (!options.json) print_answer(read);
  });
  return done;
}

/// Converts the argument from JSON: "0.5" to a number, "true" to a boolean, "[1, 2]" to a list. Text that is
/// not JSON becomes a string.
nlohmann::json value_of(const std::string& text) {
  const nlohmann::json parsed = parse_command(text);
  return parsed.is_discarded() ? nlohmann::json(text) : parsed;
}

/// Adds a command-line argument to `cli`. Its value becomes a member of the JSON object `command`.
void add_argument(CLI::App& cli, const Argument& argument, nlohmann::json& command) {
  using Type = Argument::Type;
  static const std::map<Type, CLI::Validator> checks{{Type::on_or_off, one_of({"on", "off"})},
                                                     {Type::number, finite_number()},
                                                     {Type::duration_s, positive_number()},
                                                     {Type::timeout_s, number_between(0.001, 1e6)},
                                                     {Type::fault, one_of(twin::words(twin::Fault{}))},
                                                     {Type::node, one_of(twin::words(twin::Node{}))}};
  const std::string name(argument.ctl), meaning(argument.meaning);
  const auto take_number = [&command, argument](double number) { command[argument.name] = number; };
  const auto take_text = [&command, argument](const std::string& text) {
    command[argument.name] = argument.type == Type::on_or_off ? nlohmann::json(text == "on")
                             : argument.type == Type::value   ? value_of(text)
                                                              : nlohmann::json(text);
  };
  CLI::Option* option = argument.is_number() ? cli.add_option_function<double>(name, take_number, meaning)
                                             : cli.add_option_function<std::string>(name, take_text, meaning);
  option->required(argument.is_needed);
  if (const auto check = checks.find(argument.type); check != checks.end()) option->check(check->second);
}

}  // namespace

void add_ctl(CLI::App& cli, int& status) {
  const auto options = std::make_shared<CtlArguments>();
  CLI::App* ctl =
      cli.add_subcommand("ctl", "Send a command to a running controller or twin over its control socket");
  ctl->require_subcommand(1);
  ctl->add_option("--socket", options->socket, "file of the control socket");
  ctl->add_option("--interface", options->interface,
                  "CAN interface of the controller (or twin), if there is no --socket")
      ->check(interface_name())
      ->capture_default_str();
  ctl->add_flag("--twin", options->twin, "send the command to the twin instead of the controller");
  ctl->add_flag("--json", options->json, "print the answer as JSON");
  ctl->add_option("--timeout", options->answer_timeout_s,
                  "time limit for the answer in seconds; `wait` has its own time limit")
      ->check(number_between(0.001, 1e6))
      ->capture_default_str();
  for (const ControlCommand& row : protocol::commands) {
    CLI::App* command = ctl->add_subcommand(std::string(row.ctl_word()), std::string(row.meaning));
    command->fallthrough();
    for (const Argument& argument : row.arguments) add_argument(*command, argument, options->command);
    command->callback([options, &row, &status] {
      options->command["do"] = row.word;
      status = run(*options, row);
    });
  }
}

}  // namespace hystcan::app
