// Executes the commands of a twin's control socket: show the status of nodes and stages, inject and remove
// faults, stop. It runs on the thread of the twin, between two events, and answers every command immediately.
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
  /// `stop`: function that ends the twin, called for the command `stop`.
  TwinCommandHandler(twin::Twin& twin, can::Scheduler& scheduler, std::function<void()> stop);

  void forget(const void*) override {}  // nothing to drop, because every command is answered at once

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
