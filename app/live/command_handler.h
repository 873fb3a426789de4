// The interface between a control socket and the process that it commands, with two implementations:
// ControllerCommandHandler and TwinCommandHandler.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/live/control_protocol.h"
#include "base/error.h"

namespace hystcan::app {

/// Sends the answer to a command: {"ok": true, ...} or {"ok": false, "error": "..."}. Each command gets
/// exactly one answer.
struct Answer {
  std::function<void(nlohmann::json)> send;
  const void* client = nullptr;  ///< identifies the client for CommandHandler::forget(); may be null
  void operator()(nlohmann::json result) const { send(std::move(result)); }
};

class CommandHandler {
 public:
  explicit CommandHandler(Server of) : server(of) {}
  virtual ~CommandHandler() = default;
  CommandHandler(const CommandHandler&) = delete;
  CommandHandler& operator=(const CommandHandler&) = delete;

  /// Executes a command from the socket: {"do": "enable", "axis": "x"}.
  void execute(const nlohmann::json& command, const Answer& answer) {
    try {
      carry_out(take_command(command, server).verb, command, answer);
    } catch (const std::exception& error) {
      answer(refusal(error_text(error)));
    }
  }
  /// Drops the pending commands of a client that disconnected.
  virtual void forget(const void* client) = 0;

  const Server server;

 private:
  /// Throws if the command is invalid; nothing is changed then.
  virtual void carry_out(Verb verb, const nlohmann::json& command, const Answer& answer) = 0;
};

}  // namespace hystcan::app
