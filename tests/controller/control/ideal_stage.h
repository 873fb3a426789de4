// An axis and its actuator for tests. The actuator is the model itself with its creep, without dynamics,
// noise or a bus.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>

#include "controller/control/axis.h"
#include "tests/controller/control/healthy.h"
#include "tests/support/piezo.h"

namespace hystcan::controller {

inline constexpr double cycle_s = 1e-3;

/// An axis with an ideal actuator: the model itself, without dynamics.
class IdealStage {
 public:
  explicit IdealStage(const AxisConfig& config = support::piezo_axis())
      : IdealStage(config, model::Hysteresis(config.law.model).virgin(0.0)) {}
  IdealStage(const AxisConfig& config, const model::HysteresisState& memory)
      : axis(config),
        actuator_(config.law.model),
        memory_(memory),
        creep_(config.law.creep),
        creep_state_(creep_.settled(memory.output)) {}

  /// Input of the next cycle.
  AxisInput next_input() const {
    NodeHealth health = all_is_well;
    health.amplifier_enabled = command.enable;
    health.amplifier_output = memory_.input;
    return {.time_s = time_s + cycle_s,
            .dt_s = cycle_s,
            .cycle_s = cycle_s,
            .position_um = creep_.output(creep_state_, memory_.output),
            .tracking_since_s = begin_s(),
            .health = health};
  }
  AxisCommand cycle(const std::function<void(AxisInput&)>& disturb = {}) {
    AxisInput input = next_input();
    time_s = input.time_s;
    if (disturb) disturb(input);
    command = axis.step(input);
    highest_drive = std::max(highest_drive, command.drive);
    actuator_.advance(memory_, command.enable ? command.drive : axis.config().gate.safe_drive);
    hold(cycle_s);
    return command;
  }
  bool reaches(AxisState state, int within_cycles = 2000) {
    for (int i = 0; i < within_cycles && axis.state() != state; ++i) cycle();
    return axis.state() == state;
  }
  bool tracks() {
    axis.start(false);
    return reaches(AxisState::tracking);
  }

  /// Advances the time without a cycle.
  void hold(double for_s) { creep_.advance(creep_state_, memory_.output, for_s); }

  const model::HysteresisState& memory() const { return memory_; }

  Axis axis;
  AxisCommand command;
  double time_s = 0.0;
  double highest_drive = 0.0;

 private:
  std::optional<double> begin_s() const {
    if (axis.state() != AxisState::ready) return std::nullopt;
    return time_s + cycle_s;
  }

  model::Hysteresis actuator_;
  model::HysteresisState memory_;
  model::OutputCreep creep_;
  model::OutputCreep::State creep_state_;
};

}  // namespace hystcan::controller
