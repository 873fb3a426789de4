#include "app/live/twin_command_handler.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <utility>

#include "app/live/answer_json.h"
#include "base/error.h"
#include "config/schema/config.h"

namespace hystcan::app {
namespace {

using nlohmann::json;

constexpr double longest_s = 1e6;  // longest duration of an injected fault in s: about twelve days

std::string_view to_string(can::NmtState state) {
  using enum can::NmtState;
  if (state == stopped) return "stopped";
  if (state == operational) return "operational";
  return state == pre_operational ? "pre-operational" : "off";
}

twin::Fault fault_of(const json& command) {
  const std::string name = text_of(command, "kind");
  if (const auto kind = parse_word<twin::Fault>(name)) return *kind;
  throw Error(fmt::format("there is no fault \"{}\"", name),
              expect("one of {}", fmt::join(words(twin::Fault{}), ", ")));
}

can::Duration duration_of(const json& command) {
  if (!command.contains("duration_s")) return {};
  const double duration_s = number_of(command, "duration_s");
  if (!(duration_s > 0.0 && duration_s <= longest_s))
    throw Error(fmt::format("duration_s is {:g}", duration_s), expect("more than 0, up to {:g}", longest_s));
  return can::Duration(std::llround(1e9 * duration_s));
}

}  // namespace

std::string_view to_string(can::AmpState state) {
  static constexpr std::array<std::string_view, 4> names{"off", "ready", "enabled", "tripped"};
  return names[static_cast<std::size_t>(state)];
}

TwinCommandHandler::TwinCommandHandler(twin::Twin& twin, can::Scheduler& scheduler,
                                       std::function<void()> stop)
    : CommandHandler(Server::twin),
      twin_(twin),
      scheduler_(scheduler),
      started_(scheduler.now()),
      stop_(std::move(stop)) {}

void TwinCommandHandler::carry_out(Verb verb, const json& command, const Answer& answer) {
  if (verb == Verb::status) return answer(status());
  if (verb == Verb::inject) return answer(inject(command));
  if (verb == Verb::remove) return answer(remove(command));
  stop_();
  answer(answer_json(DoneAnswer{}));
}

json TwinCommandHandler::status() {
  const can::Time now = scheduler_.now();
  TwinStatusAnswer status{.time_s = time_s(now)};
  for (const auto& axis : twin_.axes()) {
    axis->plant.advance_to(now);
    status.axes.push_back({.name = axis->name,
                           .amplifier = std::string(to_string(axis->amplifier.state())),
                           .amplifier_fault = axis->amplifier.fault(),
                           .sensor = std::string(to_string(axis->sensor.node().state())),
                           .drive = axis->plant.drive(),
                           .position_um = axis->plant.position_um()});
  }
  for (const auto& fault : twin_.faults().active()) status.faults.push_back(answer_of(fault));
  return answer_json(std::move(status));
}

TwinFaultAnswer TwinCommandHandler::answer_of(const twin::FaultScheduler::Active& fault) const {
  const twin::FaultSpec& spec = fault.spec;
  const twin::FaultTraits& kind = traits(spec.kind);
  TwinFaultAnswer answer{.kind = spec.kind, .axis = spec.axis, .began_s = time_s(fault.began)};
  if (kind.site != twin::FaultSite::plant) answer.node = spec.node;
  if (!kind.unit.empty()) answer.value = spec.value;
  if (spec.lasts > can::Duration::zero()) answer.ends_s = time_s(fault.ends);
  return answer;
}

/// Returns the axis that the command names. If the twin has only one axis, the command need not name it.
std::string TwinCommandHandler::axis_of(const json& command) const {
  if (!command.contains("axis") && twin_.axes().size() == 1) return twin_.axes().front()->name;
  return text_of(command, "axis");
}

json TwinCommandHandler::inject(const json& command) {
  twin::FaultSpec spec = twin::fault_spec(fault_of(command), axis_of(command));
  if (command.contains("node")) {
    const std::string name = text_of(command, "node");
    const auto node = parse_word<twin::Node>(name);
    if (!node) throw Error(fmt::format("node is \"{}\"", name), expect("sensor or amplifier"));
    spec.node = *node;
  }
  if (command.contains("value")) {
    if (traits(spec.kind).unit.empty())
      throw Error(fmt::format("a value is not allowed for the fault {}", traits(spec.kind).name));
    spec.value = number_of(command, "value");
  }
  spec.lasts = duration_of(command);
  twin_.faults().inject(spec);
  return answer_json(FaultAnswer{.fault = twin::describe(spec)});
}

json TwinCommandHandler::remove(const json& command) {
  std::optional<twin::Fault> kind;
  if (command.contains("kind")) kind = fault_of(command);
  const std::string axis = command.contains("axis") ? text_of(command, "axis") : "";
  return answer_json(RemovedAnswer{.removed = twin_.faults().remove(kind, axis)});
}

}  // namespace hystcan::app
