#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "app/command_line/commands.h"
#include "app/command_line/status_text.h"
#include "app/live/command_handler.h"
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
  std::string axis;
  double position_um = 0.0;
  std::string key;
  std::string value;
  double timeout_s = 0.0;  ///< of `wait`
  double answer_timeout_s = 5.0;
  bool twin = false;
  std::string kind;
  std::string node;
  std::optional<double> duration_s;
  std::optional<double> fault_value;
};

/// Sends one command and returns its answer. `process`: controller or twin, for the message of an error.
nlohmann::json exchange(const std::filesystem::path& file, const nlohmann::json& command, const char* process,
                        std::optional<std::chrono::milliseconds> limit) {
  try {
    return ask_socket(file, command, limit);
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::timed_out)
      throw RunError(fmt::format("{}: no answer within {:g} s (--timeout): the {} does not read its socket",
                                 file.string(), std::chrono::duration<double>(*limit).count(), process));
    throw RunError(
        fmt::format("{}: {}; is the {} running, with this interface? (--interface, --socket, control_socket)",
                    file.string(), error.code().message(), process));
  }
}

/// `wait` may take as long as it says, and without a time as long as it takes.
std::optional<std::chrono::milliseconds> limit_of(const CtlArguments& options,
                                                  const nlohmann::json& command) {
  const bool waits = command.at("do") == "wait";
  if (waits && options.timeout_s <= 0.0) return std::nullopt;
  const double limit_s = options.answer_timeout_s + (waits ? options.timeout_s : 0.0);
  return std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double>(limit_s));
}

std::string number(const nlohmann::json& value) {
  return value.is_number() ? fmt::format("{:.4f}", value.get<double>()) : "-";
}

void print_twin_status(const nlohmann::json& status) {
  print("{:.1f} s\n", status.at("time_s").get<double>());
  print("{:<8} {:<10} {:<16} {:>10} {:>12}\n", "axis", "amplifier", "sensor", "drive", "position um");
  for (const nlohmann::json& axis : status.at("axes"))
    print("{:<8} {:<10} {:<16} {:>10} {:>12}\n", axis.at("name").get<std::string>(),
          axis.at("amplifier").get<std::string>(), axis.at("sensor").get<std::string>(),
          number(axis.at("drive")), number(axis.at("position_um")));
  for (const nlohmann::json& fault : status.at("faults")) {
    const std::string site = fault.value("node", "stage");
    std::string line = fmt::format("{} of {}: {}", site, fault.at("axis").get<std::string>(),
                                   fault.at("kind").get<std::string>());
    if (fault.contains("value")) line += fmt::format(" {:g}", fault.at("value").get<double>());
    line += fmt::format(", since {:.3f} s", fault.at("began_s").get<double>());
    if (fault.contains("ends_s")) line += fmt::format(" until {:.3f} s", fault.at("ends_s").get<double>());
    print("{}\n", line);
  }
}

void print_removed(std::size_t faults) { print("{} removed\n", counted(faults, "fault")); }

void print_answer(const nlohmann::json& answer) {
  if (answer.contains("faults")) return print_twin_status(answer);
  if (answer.contains("axes")) {
    for (const std::string& line : status_lines(answer)) print("{}\n", line);
    return;
  }
  if (answer.contains("fault")) print("{}\n", answer.at("fault").get<std::string>());
  if (answer.contains("removed")) print_removed(answer.at("removed").get<std::size_t>());
  if (answer.contains("run")) print("{}\n", answer.at("run").get<std::string>());
  if (answer.contains("position_um"))
    print("in position at {:.4f} um\n", answer.at("position_um").get<double>());
  for (const nlohmann::json& line : answer.value("nothing_to_do", nlohmann::json::array()))
    print("{}\n", line.get<std::string>());
  const char* changes = answer.contains("unsaved") ? "unsaved" : "changed";
  for (const nlohmann::json& change : answer.value(changes, nlohmann::json::array()))
    print("{}: {} -> {}\n", change.at("key").get<std::string>(), change.at("from").get<std::string>(),
          change.at("to").get<std::string>());
}

int run(const CtlArguments& options, const nlohmann::json& command) {
  const bool to_twin = options.twin || command.at("do") == "inject" || command.at("do") == "remove";
  const std::filesystem::path file = !options.socket.empty() ? std::filesystem::path(options.socket)
                                     : to_twin               ? find_twin_socket(options.interface)
                                                             : find_socket(options.interface);
  const nlohmann::json answer =
      exchange(file, command, to_twin ? "twin" : "controller", limit_of(options, command));
  if (options.json) print("{}\n", answer.dump(2));
  if (!answer.value("ok", false)) throw RunError(answer.value("error", "the answer has no \"error\""));
  if (!options.json) print_answer(answer);
  return done;
}

/// The argument as a number, a boolean or a list; any other word is a string.
nlohmann::json value_of(const std::string& text) {
  const nlohmann::json parsed = parse_command(text);
  return parsed.is_discarded() ? nlohmann::json(text) : parsed;
}

/// record and set.
void add_commands_with_values(const auto& add, const auto& run_as, CtlArguments& options) {
  CLI::App* record = add("record", "record a run, or end it: on, off");
  record->add_option("ON", options.value, "on or off")->required()->check(one_of({"on", "off"}));
  run_as(record, [](const CtlArguments& o) {
    return nlohmann::json{{"do", "record"}, {"on", o.value == "on"}};
  });
  CLI::App* set = add("set", "change one key of [axis.control] until the file is read again");
  set->add_option("AXIS", options.axis)->required();
  set->add_option("KEY", options.key, "kp, structure, delays.resonance_Hz, ...")->required();
  set->add_option("VALUE", options.value)->required();
  run_as(set, [](const CtlArguments& o) {
    return nlohmann::json{{"do", "set"}, {"axis", o.axis}, {"key", o.key}, {"value", value_of(o.value)}};
  });
}

/// The commands that only a twin accepts.
void add_twin_commands(const auto& add, const auto& run_as, CtlArguments& options) {
  CLI::App* inject = add("inject", "inject a fault into the twin; it begins now");
  const CLI::Validator kind = one_of(twin::words(twin::Fault{}));
  inject->add_option("KIND", options.kind, "kind of fault")->required()->check(kind);
  inject->add_option("--axis", options.axis, "may be left out if the twin has only one axis");
  inject->add_option("--node", options.node, "if the kind of fault can act on either")
      ->check(one_of(twin::words(twin::Node{})));
  inject->add_option("--duration", options.duration_s, "seconds; if left out, until the fault is removed")
      ->check(positive_number());
  inject->add_option("--value", options.fault_value, "the strength of the fault, in the unit of its kind")
      ->check(finite_number());
  run_as(inject, [](const CtlArguments& o) {
    nlohmann::json request{{"do", "inject"}, {"kind", o.kind}};
    if (!o.axis.empty()) request["axis"] = o.axis;
    if (!o.node.empty()) request["node"] = o.node;
    if (o.duration_s) request["duration_s"] = *o.duration_s;
    if (o.fault_value) request["value"] = *o.fault_value;
    return request;
  });
  CLI::App* remove = add("remove", "remove faults that were injected into the twin");
  remove->add_option("KIND", options.kind, "all kinds if left out")->check(kind);
  remove->add_option("--axis", options.axis, "all axes if left out");
  run_as(remove, [](const CtlArguments& o) {
    nlohmann::json request{{"do", "remove"}};
    if (!o.kind.empty()) request["kind"] = o.kind;
    if (!o.axis.empty()) request["axis"] = o.axis;
    return request;
  });
}

}  // namespace

void add_ctl(CLI::App& cli, int& status) {
  const auto options = std::make_shared<CtlArguments>();
  CLI::App* ctl =
      cli.add_subcommand("ctl", "Command a running controller, or a twin, over its control socket");
  ctl->require_subcommand(1);
  ctl->add_option("--socket", options->socket, "the control socket's file");
  ctl->add_option("--interface", options->interface,
                  "without --socket: the socket of the controller (or twin) on this CAN interface")
      ->check(interface_name())
      ->capture_default_str();
  ctl->add_flag("--twin", options->twin, "command the twin on this interface, not the controller");
  ctl->add_flag("--json", options->json, "print the answer as JSON");
  ctl->add_option("--timeout", options->answer_timeout_s,
                  "seconds to wait for the answer; `wait` has its own")
      ->check(number_between(0.001, 1e6))
      ->capture_default_str();
  const auto add = [&](const char* name, const char* what) {
    CLI::App* command = ctl->add_subcommand(name, what);
    command->fallthrough();
    return command;
  };
  const auto run_as = [&](CLI::App* command, auto make) {
    command->callback([options, make, &status] { status = run(*options, make(*options)); });
  };
  const auto add_act = [&](const char* name, const char* what, bool takes_axis) {
    CLI::App* command = add(name, what);
    if (takes_axis) command->add_option("AXIS", options->axis, "all axes if left out");
    run_as(command, [verb = std::string(name)](const CtlArguments& o) {
      nlohmann::json request{{"do", verb}};
      if (!o.axis.empty()) request["axis"] = o.axis;
      return request;
    });
  };
  add_act("status", "show the state of every axis", false);
  add_act("reload", "read the configuration file again", false);
  add_act("undo", "take back the last set since the file was read", false);
  add_act("settings", "show what is in force and not in the file; with --json all keys", false);
  add_act("stop", "ramp every axis down, switch off, and end the controller, or the twin", false);
  add_act("enable", "start an axis that is offline", true);
  add_act("disable", "ramp an axis down and switch it off", true);
  add_act("clear", "clear the fault of an axis; the axis is then offline", true);
  add_act("resume", "follow the configured reference again", true);
  add_act("revert", "discard all that the axis has learnt so far", true);
  CLI::App* go = add("go", "leave the reference, move to a position and stay there");
  go->add_option("AXIS", options->axis)->required();
  go->add_option("POSITION", options->position_um, "um")->required()->check(finite_number());
  run_as(go, [](const CtlArguments& o) {
    return nlohmann::json{{"do", "go_to"}, {"axis", o.axis}, {"position_um", o.position_um}};
  });
  CLI::App* wait = add("wait", "wait until the axis is in position; fail if it does not arrive");
  wait->add_option("AXIS", options->axis)->required();
  wait->add_option("--timeout", options->timeout_s, "seconds")->check(number_between(0.001, 1e6));
  run_as(wait, [](const CtlArguments& o) {
    nlohmann::json request{{"do", "wait"}, {"axis", o.axis}};
    if (o.timeout_s > 0.0) request["timeout_s"] = o.timeout_s;
    return request;
  });
  add_commands_with_values(add, run_as, *options);
  add_twin_commands(add, run_as, *options);
}

}  // namespace hystcan::app
