// What is physical about one axis: amplifier, hysteretic actuator, one mechanical mode.
//
//   v(t)   drive, by the amplifier (twin/amplifier.h), plus its noise n, held over a sub-step
//   x_h  = H[v + n](t)                                     hysteresis
//   u    = x_h + (g - 1)(x_h - x_0) + d                    g, d: gain and load of the Disturbance; x_0:
//   x_h(0) x''  + 2 zeta omega x' + omega^2 x = omega^2 u(t)      position
//
// Sub-steps lie on a fixed grid, whole multiples of `substep` from the start; a change of the target, or a
// disturbance, splits the sub-step in which it falls.  Amplifier and mode are exact for any length, u is
// taken as linear in time between those points.  v is monotone there, so that no turning point is ever
// stepped over.
//
// Looking changes nothing, to the bit: what lies between the last such point and the time looked at is
// computed on a copy.  What has come to rest is not stepped on.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "can/scheduler.h"
#include "model/hysteresis.h"
#include "model/second_order.h"
#include "twin/amplifier.h"

namespace hystcan::twin {

/// What happens to a stage in operation.
struct Disturbance {
  double load_um = 0.0;    ///< displacement of a static load
  double gain = 1.0;       ///< factor on the hysteresis output's travel from where the stage started
  double resonance = 1.0;  ///< factor on the natural frequencies, > 0
};

class Plant {
 public:
  struct Config {
    model::HysteresisParameters hysteresis;
    model::SecondOrder::Config mode;
    Amplifier::Config amplifier;
    can::Duration substep{50'000};
  };

  /// At rest at `start`, the amplifier at its safe value, the actuator on its virgin curve.
  /// Throws std::invalid_argument where the hysteresis is not a valid one, or a parameter out of range.
  Plant(const Config& config, can::Time start);

  /// Looks at `time`, which is the present from then on; an earlier time changes nothing.
  void advance_to(can::Time time);
  /// Sets the amplifier's target from the present time on, limited to its range.
  void set_target(double drive);
  /// From the present time on. Throws std::invalid_argument where a number is not finite, or resonance <= 0.
  void disturb(const Disturbance& disturbance);

  /// Called at the end of every sub-step of the fixed grid, position linear in between. A rest counts as one
  /// sub-step, a whole number of times as long: the handler is called at its end.
  using GridHandler = std::function<void(can::Time, double position_um)>;
  void on_grid(GridHandler handler) { on_grid_ = std::move(handler); }
  /// Drive units added to the amplifier's output, asked for once for each sub-step and held over it: with the
  /// time at which it begins, from the next one on. While there is a function, nothing counts as rest.
  using DriveNoise = std::function<double(can::Time)>;
  void set_drive_noise(DriveNoise noise) { drive_noise_ = std::move(noise); }

  /// What the actuator gets: the amplifier's output and its noise.
  double drive() const { return present_.amplifier.output + noise_; }
  double position_um() const { return present_.mode.position; }
  /// x_h, before load and mode.
  double hysteresis_um() const { return present_.hysteresis_um; }

 private:
  /// All that moves, but for what the hysteresis remembers.
  struct Motion {
    can::Time time;
    Amplifier::State amplifier;
    double hysteresis_um = 0.0;  ///< x_h
    double input_um = 0.0;       ///< u
    model::SecondOrder::State mode;
  };
  /// Over one length of time.
  struct Step {
    Step(const Config& config, can::Duration step_length);
    can::Duration length;
    Amplifier::Step amplifier;
    model::SecondOrder::Step mode;
  };

  template <class Hysteresis>
  void move(Motion& motion, const Step& step, Hysteresis hysteresis);
  const Step& step_of(can::Duration length);
  void reach_grid();
  void split();
  void skip_rest(can::Time time);
  bool has_settled();
  double input_um(const Motion& motion) const;

  Config config_;  ///< natural frequencies as disturbed
  model::SecondOrder::Config undisturbed_mode_;
  Disturbance disturbance_;
  model::Hysteresis hysteresis_;
  model::HysteresisState memory_;  ///< as of settled_
  double rest_um_;                 ///< x_0
  Step substep_;
  std::array<std::optional<Step>, 128>
      parts_;       ///< of a sub-step: commands come again and again at the same ones
  Motion settled_;  ///< at the last grid point, change of target, or disturbance
  Motion present_;  ///< at the time looked at
  can::Time next_grid_;
  double noise_ = 0.0;  ///< n
  GridHandler on_grid_;
  DriveNoise drive_noise_;
};

}  // namespace hystcan::twin
