// Converts the commands of the control socket and the changes of the configuration file to requests to the
// control thread, and returns its answers. All of this runs on one thread, not on the control thread.
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
  /// Reads the file again, applies it if it is valid, and logs the result.
  void reload(const Answer& answer);
  /// Answers all waiting clients, because the controller ends.
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
  using Outcome = std::vector<Refused>;  ///< empty if every axis carried out its request
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
  std::vector<std::uint64_t> last_before_act_;  ///< last cycle of each axis before the request; later records
                                                ///< show its effect
  std::map<const controller::Request*, std::function<void(controller::Request&)>> pending_;
  std::vector<Waiter> waiters_;
  bool armed_ = false;
  bool closed_ = false;
};

}  // namespace hystcan::app
