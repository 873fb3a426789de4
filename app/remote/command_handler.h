// Who is behind a control socket: obeys commands and answers each once. ControllerCommandHandler of a
// controller, TwinCommandHandler of a twin.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace hystcan::app {

/// {"ok": true, ...} or {"ok": false, "error": "..."}; told once to each command.
struct Answer {
  std::function<void(nlohmann::json)> tell;
  const void* asker = nullptr;  ///< whom CommandHandler::forget() takes back; null: nobody
  void operator()(nlohmann::json result) const { tell(std::move(result)); }
};

nlohmann::json refusal(const std::string& why);

/// The text or number of this key. Throws config::Error where there is none.
std::string text_of(const nlohmann::json& command, const char* key);
double number_of(const nlohmann::json& command, const char* key);

class CommandHandler {
 public:
  CommandHandler() = default;
  virtual ~CommandHandler() = default;
  CommandHandler(const CommandHandler&) = delete;
  CommandHandler& operator=(const CommandHandler&) = delete;

  /// A command as it came over the socket: {"do": "enable", "axis": "x"}.
  virtual void obey(const nlohmann::json& command, Answer answer) = 0;
  /// Whoever asked has gone: nothing of theirs goes on.
  virtual void forget(const void* asker) = 0;
  /// True of commands that change nothing, and of those that end something: nobody may be kept from these.
  virtual bool is_for_everybody(const nlohmann::json& command) const = 0;
};

}  // namespace hystcan::app
