// The interface between a control socket and the process that executes the socket's commands.
// ControllerCommandHandler and TwinCommandHandler implement it.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/live/control_protocol.h"
#include "base/error.h"

namespace hystcan::app {

/// Sends the answer to one command: {"ok": true, ...} or {"ok": false, "error": "..."}. A handler calls it
/// exactly once per command, unless the client disconnects first.
struct Answer {
  std::function<void(nlohmann::json)> send;
  const void* client = nullptr;  ///< client that sent the command; null: no client. When a client
                                 ///< disconnects, CommandHandler::forget() drops its commands
  void operator()(nlohmann::json result) const { send(std::move(result)); }
};

class CommandHandler {
 public:
  explicit CommandHandler(Server of) : server(of) {}
  virtual ~CommandHandler() = default;
  CommandHandler(const CommandHandler&) = delete;
  CommandHandler& operator=(const CommandHandler&) = delete;

  /// Executes a command such as {"do": "enable", "axis": "x"}. If that throws, the answer is a refusal with
  /// the text of the exception.
  void execute(const nlohmann::json& command, const Answer& answer) {
    try {
      carry_out(take_command(command, server).verb, command, answer);
    } catch (const std::exception& error) {
      answer(refusal(error_text(error)));
    }
  }
  /// Drops the pending commands of a client. Called when the client disconnects.
  virtual void forget(const void* client) = 0;

  const Server server;

 private:
  /// Executes a command. Only the name of the command was checked before (`verb`). If an argument is invalid,
  /// throws and changes nothing.
  virtual void carry_out(Verb verb, const nlohmann::json& command, const Answer& answer) = 0;
};

}  // namespace hystcan::app
