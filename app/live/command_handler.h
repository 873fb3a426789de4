// The interface between a control socket and the process that it commands. It has two implementations:
// ControllerCommandHandler and TwinCommandHandler.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "config/schema/settings.h"

namespace hystcan::app {

/// Parses one line of the socket, a command or an answer. Returns something other than an object if the line
/// is neither, or is nested deeper than eight levels.
nlohmann::json parse_command(const std::string& line);

/// Sends the answer to a command: {"ok": true, ...} or {"ok": false, "error": "..."}. Each command gets
/// exactly one answer.
struct Answer {
  std::function<void(nlohmann::json)> send;
  const void* client = nullptr;  ///< for CommandHandler::forget(); may be null
  void operator()(nlohmann::json result) const { send(std::move(result)); }
};

nlohmann::json refusal(const std::string& reason);

/// The text or number of this key. Throws Error if the key is missing or has another type.
std::string text_of(const nlohmann::json& command, const char* key);
double number_of(const nlohmann::json& command, const char* key);

/// A list of {"key": ..., "from": ..., "to": ...}, to write and to read.
nlohmann::json to_json(const std::vector<config::Change>& changes);
std::vector<config::Change> changes_of(const nlohmann::json& list);

class CommandHandler {
 public:
  CommandHandler() = default;
  virtual ~CommandHandler() = default;
  CommandHandler(const CommandHandler&) = delete;
  CommandHandler& operator=(const CommandHandler&) = delete;

  /// Carries out a command from the socket: {"do": "enable", "axis": "x"}.
  virtual void obey(const nlohmann::json& command, Answer answer) = 0;
  /// The client has disconnected: drops its pending commands.
  virtual void forget(const void* client) = 0;
  /// True if every connection may send the command: it changes nothing, or it ends something.
  virtual bool is_open_to_all(const nlohmann::json& command) const = 0;
};

}  // namespace hystcan::app
