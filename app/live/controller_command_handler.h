// Translates the commands of the control socket and the changes of the configuration file into requests to
// the control thread, and returns the answers of the control thread. All this code runs on one thread, which
// is not the control thread.
//
//   ControlSocket (line-delimited JSON) ──▶ ControllerCommandHandler ──▶ RequestLink ──▶ control thread
//   file watch, SIGHUP ──▶ LiveConfig ──────┘    └──▶ CycleOutlets (newest cycle records, recorder)
//
// docs/control_socket.md lists the commands.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/live/command_handler.h"
#include "app/live/control_answers.h"
#include "app/live/cycle_outlets.h"
#include "app/live/live_config.h"
#include "controller/requests.h"

namespace hystcan::app {

class ControllerCommandHandler final : public CommandHandler {
 public:
  ControllerCommandHandler(boost::asio::io_context& context, controller::RequestLink& requests,
                           CycleOutlets& outlets, LiveConfig& live);

  void forget(const void* client) override;
  /// Reads the configuration file again, applies it if it is valid, and logs the result.
  void reload(const Answer& answer);
  /// Answers all waiting clients with a refusal, because the controller is about to end.
  void close();

 private:
  struct Waiter {
    std::size_t axis;
    std::uint64_t since_cycle;
    boost::asio::steady_timer::time_point deadline;
    Answer answer;
  };

  void carry_out(Verb verb, const nlohmann::json& command, const Answer& answer) override;
  nlohmann::json status() const;
  nlohmann::json settings() const;
  nlohmann::json record(const nlohmann::json& command);
  void act(controller::Request::Kind kind, const nlohmann::json& command, const Answer& answer);
  void wait(const nlohmann::json& command, const Answer& answer);
  void set(const nlohmann::json& command, const Answer& answer);

  void apply(LiveConfig::Prepared prepared, const Answer& answer);
  struct Refused {
    std::string axis;
    controller::Refusal why;
  };
  using Outcome = std::vector<Refused>;  ///< refusals; empty if every axis executed its request
  void ask_all(std::vector<std::unique_ptr<controller::Request>> requests,
               std::function<void(const Outcome&)> done);
  static std::vector<std::string> texts_of(const Outcome& outcome);
  static RefusedAnswer refusal_of(const Outcome& outcome);
  std::vector<std::size_t> axes_of(const nlohmann::json& command) const;
  void arm();
  void collect_answers();
  void answer_waiters();

  boost::asio::steady_timer timer_;
  controller::RequestLink& requests_;
  CycleOutlets& outlets_;
  LiveConfig& live_;
  /// For each axis, the cycle in which its last request was executed. Only later cycle records show the
  /// effect of the request.
  std::vector<std::uint64_t> last_before_act_;
  std::map<const controller::Request*, std::function<void(controller::Request&)>> pending_;
  std::vector<Waiter> waiters_;
  bool armed_ = false;
  bool closed_ = false;
};

}  // namespace hystcan::app
