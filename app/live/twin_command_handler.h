// Handles the commands of a twin's control socket: status of its nodes and stages, injection and removal of
// faults, stop. It runs on the twin's own thread, between two of its events, and answers every command
// immediately.
//
// docs/twin.md lists the commands.
#pragma once

#include <functional>
#include <string_view>

#include "app/live/command_handler.h"
#include "app/live/control_answers.h"
#include "twin/twin.h"

namespace hystcan::app {

std::string_view to_string(can::AmpState state);

class TwinCommandHandler final : public CommandHandler {
 public:
  /// `stop` ends the twin.
  TwinCommandHandler(twin::Twin& twin, can::Scheduler& scheduler, std::function<void()> stop);

  void forget(const void*) override {}  // no command is ever pending

 private:
  void carry_out(Verb verb, const nlohmann::json& command, const Answer& answer) override;
  nlohmann::json status();
  nlohmann::json inject(const nlohmann::json& command);
  nlohmann::json remove(const nlohmann::json& command);
  TwinFaultAnswer answer_of(const twin::FaultScheduler::Active& fault) const;
  std::string axis_of(const nlohmann::json& command) const;
  double time_s(can::Time time) const { return can::seconds(time - started_); }

  twin::Twin& twin_;
  can::Scheduler& scheduler_;
  can::Time started_;
  std::function<void()> stop_;
};

}  // namespace hystcan::app
