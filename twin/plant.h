// What is physical about one axis: amplifier, hysteretic actuator, one mechanical mode.
//
//   command -> amplifier v(t) -> hysteresis x_h = H[v](t) -> x'' + 2 zeta omega x' + omega^2 x = omega^2
//   x_h(t)
//
// Amplifier and mode are integrated exactly; x_h is taken as linear in time within a sub-step. Sub-steps
// count from where the plant was last looked at or commanded, so that no turning point is ever stepped over.
// What has come to rest is not stepped on.
#pragma once

#include "can/scheduler.h"
#include "model/hysteresis.h"
#include "model/second_order.h"
#include "twin/amplifier.h"

namespace hystcan::twin {

class Plant {
 public:
  struct Config {
    model::HysteresisParameters hysteresis;
    model::SecondOrder::Config mode;
    Amplifier::Config amplifier;
    can::Duration substep{50'000};
  };

  /// At rest at `start`, the amplifier at its safe value, the actuator on its virgin curve.
  /// Throws std::invalid_argument where the hysteresis is not a valid one.
  Plant(const Config& config, can::Time start);

  /// Moves on to `time`; an earlier time changes nothing.
  void advance_to(can::Time time);
  /// Sets the amplifier's target from the present time on, limited to its range, and how it gets there.
  void set_target(double drive, Amplifier::Course course = Amplifier::Course::drive);

  double drive() const { return amplifier_.output; }
  double position_um() const { return mode_.position; }

 private:
  /// Amplifier and mode over a step of one length.
  struct Step {
    Step(const Config& config, can::Duration length);
    Amplifier::Step amplifier;
    model::SecondOrder::Step mode;
  };
  void take(const Step& step);
  bool has_settled();

  Config config_;
  model::Hysteresis hysteresis_;
  Step substep_;
  can::Time now_;
  Amplifier::State amplifier_;
  model::HysteresisState memory_;
  model::SecondOrder::State mode_;
};

}  // namespace hystcan::twin
