// The control protocol: a table with each command of a control socket, its arguments, its access rights and
// its answer. The words of the protocol are only in this table. The command handlers, `hystcan ctl` with its
// help and completion, the page's server, the Python package and the table of docs/control_socket.md are all
// derived from it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/words.h"
#include "controller/requests.h"

namespace hystcan::app {

/// The commands, in the order in which an error message lists them.
enum class Verb : std::uint8_t {
  status,
  settings,
  enable,
  disable,
  clear,
  go_to,
  resume,
  wait,
  set,
  undo,
  revert,
  record,
  reload,
  inject,
  remove,
  stop
};

enum class Server : std::uint8_t { controller, twin };

/// The right that a command needs. Every connection may send a command that `reads` something or that `ends`
/// something (for example stop, disable). Only one connection at a time may send commands that `write`.
enum class Access : std::uint8_t { reads, ends, writes };
constexpr auto words(Access) { return std::to_array<std::string_view>({"reads", "ends", "writes"}); }

/// The kind of answer that a server (controller or twin) sends to a command. Each kind has a struct in
/// app/live/control_answers.h. `none`: this kind of server does not accept the command.
enum class Reply : std::uint8_t {
  none,
  done,
  changes,
  run,
  position,
  fault,
  count,
  keys,
  states,
  twin_states
};
constexpr auto words(Reply) {
  return std::to_array<std::string_view>(
      {"-", "done", "changes", "run", "position", "fault", "removed", "settings", "status", "twin status"});
}

struct Argument {
  enum class Type : std::uint8_t { text, value, on_or_off, fault, node, number, duration_s, timeout_s };
  std::string_view name;  ///< name of the JSON member in the command
  std::string_view ctl;   ///< the argument in `hystcan ctl`: positional (AXIS) or an option (--axis)
  Type type = Type::text;
  std::string_view example;
  std::string_view meaning;  ///< description in the help of `hystcan ctl`
  bool is_needed = true;

  constexpr bool is_number() const { return type >= Type::number; }
};

struct ControlCommand {
  Verb verb;
  std::string_view word;  ///< name of the command: the value of the JSON member `do`
  Access access;
  Reply controller, twin;
  int page_place;  ///< position in the error message that lists the commands a page may send; 0: a page may
                   ///< not send this command
  std::span<const Argument> arguments;
  std::string_view meaning;  ///< description of the command in the help of `hystcan ctl`
  std::optional<controller::Request::Kind> act{};  ///< request that the controller's control thread executes
                                                   ///< for this command

  constexpr std::string_view ctl_word() const { return verb == Verb::go_to ? "go" : word; }
  constexpr Reply reply_of(Server server) const { return server == Server::twin ? twin : controller; }
};

namespace protocol {
using enum Access;
using enum Reply;
using enum Verb;
using Kind = controller::Request::Kind;
using Type = Argument::Type;

inline constexpr Argument axis{"axis", "AXIS", Type::text, "x", ""};
inline constexpr std::span<const Argument> nothing{};
inline constexpr std::array any_axis{Argument{"axis", "AXIS", Type::text, "x", "axis; default: all", false}};
inline constexpr std::array position_of{axis,
                                        Argument{"position_um", "POSITION", Type::number, "12.5", "um"}};
inline constexpr std::array arrival{
    axis, Argument{"timeout_s", "--timeout", Type::timeout_s, "5", "seconds", false}};
inline constexpr std::array on_or_off{Argument{"on", "ON", Type::on_or_off, "on", "on or off"}};
inline constexpr std::array setting{
    axis, Argument{"key", "KEY", Type::text, "kp", "kp, structure, delays.resonance_Hz, ..."},
    Argument{"value", "VALUE", Type::value, "0.08", ""}};
inline constexpr auto new_fault = std::to_array<Argument>(
    {{"kind", "KIND", Type::fault, "no_reply", "kind of fault"},
     {"axis", "--axis", Type::text, "x", "axis; default: the only axis", false},
     {"node", "--node", Type::node, "sensor",
      "node with the fault; default: the only possible node, or the sensor if both nodes are possible",
      false},
     {"duration_s", "--duration", Type::duration_s, "0.5",
      "duration in seconds; default: until the fault is removed", false},
     {"value", "--value", Type::number, "",
      "strength of the fault; docs/twin.md has the unit and the default for each kind of fault", false}});
inline constexpr auto old_faults =
    std::to_array<Argument>({{"kind", "KIND", Type::fault, "no_reply", "kind of fault; default: all", false},
                             {"axis", "--axis", Type::text, "x", "axis; default: all", false}});

inline constexpr auto commands = std::to_array<ControlCommand>({
    {status, "status", reads, states, twin_states, 0, nothing, "show the state of every axis"},
    {reload, "reload", writes, changes, none, 5, nothing, "read the configuration file again"},
    {undo, "undo", writes, changes, none, 4, nothing,
     "reverse the last command `set`, unless the file was read again after it"},
    {settings, "settings", reads, keys, none, 0, nothing,
     "show the active values that differ from the file; with --json all keys"},
    {stop, "stop", ends, done, done, 0, nothing,
     "ramp every axis down, disable the amplifiers, and end the controller or the twin", Kind::stop},
    {enable, "enable", writes, done, none, 7, any_axis, "start an axis that is offline", Kind::enable},
    {disable, "disable", ends, done, none, 8, any_axis, "ramp an axis down and disable its amplifier",
     Kind::disable},
    {clear, "clear", writes, done, none, 9, any_axis, "clear the fault of an axis; the axis is then offline",
     Kind::clear},
    {resume, "resume", writes, done, none, 2, any_axis, "follow the configured reference again",
     Kind::resume},
    {revert, "revert", writes, done, none, 6, any_axis, "discard the learnt correction of an axis",
     Kind::revert},
    {go_to, "go_to", writes, done, none, 1, position_of,
     "leave the reference, move to a position and stay there", Kind::go_to},
    {wait, "wait", reads, position, none, 0, arrival,
     "wait until the axis is in position; fail if it does not arrive"},
    {record, "record", writes, run, none, 10, on_or_off, "start or end the recording of a run: on, off"},
    {set, "set", writes, changes, none, 3, setting,
     "change one key of [axis.control] until the file is read again"},
    {inject, "inject", writes, none, fault, 0, new_fault, "inject a fault into the twin now"},
    {remove, "remove", ends, none, count, 0, old_faults, "remove faults that were injected into the twin"},
});
}  // namespace protocol

constexpr const ControlCommand& row_of(Verb verb) {
  return *std::ranges::find(protocol::commands, verb, &ControlCommand::verb);
}
/// Returns the JSON object of a command without arguments, for example {"do": "status"}.
nlohmann::json command_of(Verb verb);

/// Returns the table row of the command named in `do`; null if this kind of server does not accept the
/// command.
const ControlCommand* find_command(const nlohmann::json& command, Server server);
/// Returns the same as find_command(), but throws Error with the accepted words if there is no such command.
const ControlCommand& take_command(const nlohmann::json& command, Server server);

/// Parses one line of the socket, which is a command or an answer. Callers must check is_object(): the result
/// is an object only if the line is a JSON object with at most eight nested levels.
nlohmann::json parse_command(const std::string& line);

/// Returns the member `key` of the command as text or number. Throws Error if the member is missing or has
/// another type.
std::string text_of(const nlohmann::json& command, const char* key);
double number_of(const nlohmann::json& command, const char* key);

nlohmann::json refusal(const std::string& reason);

}  // namespace hystcan::app
