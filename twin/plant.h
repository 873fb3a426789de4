// The simulated stage of an axis. class Material is the smart material of the actuator. class Plant joins the
// amplifier, the actuator and the mechanics of the stage.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "can/scheduler.h"
#include "model/any_model.h"
#include "model/creep.h"
#include "model/output_creep.h"
#include "model/second_order.h"
#include "twin/amplifier.h"

namespace hystcan::twin {

// The smart material of an actuator: a hysteresis model of any kind, and its memory.
//
//   x_h = H[v](t)
//
// v is the drive, x_h the displacement of the material, H the hysteresis model. The model is
// rate-independent: the sequence of the values of v determines x_h, the speed of v does not. Between two
// values v moves monotonically, without a turning point. If the symmetry is even (magnetostriction, x_h(v) =
// x_h(-v)), x_h turns at v = 0 while v moves on. Therefore, if v changes its sign, the material first moves
// to v = 0 and then to the new v.

class Material {
 public:
  /// Starts on the virgin curve at `drive`. `branches` is the maximum number of hysteresis branches in the
  /// memory, for a model that stores branches. Throws std::invalid_argument if the model is invalid or its
  /// range does not include `drive`.
  Material(const model::AnyParameters& parameters, double drive, std::size_t branches);

  /// Moves the material to `drive`, in drive units, limited to the range of drives of the hysteresis model.
  /// Returns the displacement, um.
  double go_to(double drive);
  /// Returns the displacement that go_to(drive) would return, without moving to `drive`. The memory does not
  /// change, with one exception: if the model has even symmetry, and `drive` and the present drive have
  /// opposite signs, the material moves to a drive of zero.
  double look_at(double drive);

 private:
  template <class Model>
  struct Kind {
    Model model;
    typename Model::State state;
  };
  template <class Model>
  static Kind<Model> virgin(Model model, double drive, std::size_t branches);
  void pass_zero(double drive);

  std::variant<Kind<model::Hysteresis>, Kind<model::LinearMapping>, Kind<model::PrandtlIshlinskii>,
               Kind<model::Preisach>>
      kind_;
  bool even_ = false;
  double drive_;
};

// The physics of one axis: amplifier, hysteretic actuator, one or two mechanical modes.
//
//   v(t)       drive: output of the amplifier (twin/amplifier.h) plus its noise, held over a sub-step
//   x_h      = H[v](t)                             output of a hysteresis model H of any kind
//   C(t)       creep of x_h - x_0, by Kuhnen's operators (model/creep.h): creep that is logarithmic in time,
//              or the creep of the hysteresis model (model/output_creep.h), or the sum of both. The model's
//              creep delays a share s of x_h - x_0: this share appears in C over time instead of at once
//   T        = swing sin(2 pi t / period)          change of the ambient temperature since the start
//   u        = x_0 + g (1 + gain_per_K T) ((1 - s) (x_h - x_0) + C) + expansion T + load
//   x_i'' + 2 zeta_i omega_i x_i' + omega_i^2 x_i = omega_i^2 u(t)
//   position = (1 - share) x_1 + share x_2
//
// x_0 is x_h at the start. u is the input of the mechanical modes. x_i is the displacement of mode i (1 or
// 2), with its damping ratio zeta_i and its natural frequency omega_i. `share` is the share of the second
// mode in the position. g (a gain of the travel), `load` and a factor on every omega_i are the members of
// struct Disturbance. At the start everything is at rest, the creep has settled, and T = 0.
//
// Sub-steps end on a fixed grid, at whole multiples of `substep` from the start. A change of the amplifier's
// target or a disturbance splits the present sub-step into parts. Amplifier and modes are exact for a part of
// any length. Within a part u is linear in time, and the creep's input is constant, the mean of both ends. v
// is monotone within a part, so no turning point is missed. A target that moves in a straight line splits the
// sub-step twice more: at the time when v turns, if v turns, and at the end of the target's motion.
//
// Reading the plant does not change its state: the motion from the end of the last part to the time of the
// reading is computed on a copy. A plant at rest is not stepped. A plant with temperature or drive noise
// never rests.

struct SecondMode {
  model::SecondOrder::Config mode;
  double share = 0.0;  ///< share of this mode in the position, 0 to 1
};

/// Creep that grows with the logarithm of time, from `from_s` to `to_s` after a step (see
/// model::logarithmic_creep).
struct LogarithmicCreep {
  double per_decade = 0.0;  ///< creep per decade of time, as a share of the response without creep
  double from_s = 0.1;
  double to_s = 1000.0;
};

struct Temperature {
  double swing_K = 0.0;   ///< amplitude of the ambient temperature, which is a sine
  double period_s = 1.0;  ///< period of the ambient temperature, > 0
  double expansion_um_per_K = 0.0;
  double gain_per_K = 0.0;  ///< relative change of the travel per kelvin
};

/// A change of the stage or of its amplifier during operation.
struct Disturbance {
  double load_um = 0.0;  ///< displacement of the stage by a static load
  double gain = 1.0;     ///< factor on the travel of the stage, which counts from the stage's start position
  double resonance = 1.0;                                       ///< factor on the natural frequencies, > 0
  double most_drive = std::numeric_limits<double>::infinity();  ///< maximum magnitude of the amplifier's
                                                                ///< output, >= 0
};

class Plant {
 public:
  struct Config {
    model::AnyParameters hysteresis;
    model::SecondOrder::Config mode;
    Amplifier::Config amplifier;
    can::Duration substep{50'000};
    std::optional<model::OutputCreep::Config> hysteresis_creep{};  ///< creep of the hysteresis model
    std::optional<SecondMode> second_mode{};
    std::optional<LogarithmicCreep> creep{};
    std::optional<Temperature> temperature{};
  };

  /// Starts at rest, with the amplifier's output at `safe_drive` and the actuator on its virgin curve. Throws
  /// std::invalid_argument if the hysteresis model is invalid or a parameter is out of range.
  Plant(const Config& config, can::Time start);

  Plant(const Plant&) = delete;  // other plants may be coupled to it
  Plant& operator=(const Plant&) = delete;

  /// Advances the plant to `time`; an earlier time changes nothing.
  void advance_to(can::Time time);
  /// Sets the amplifier's target from the present time on. `course` is how the output moves: to the target as
  /// fast as possible, to the target in a slow ramp, or to zero because the amplifier is switched off. The
  /// target is limited to the amplifier's range.
  void set_target(double drive, Amplifier::Course course = Amplifier::Course::drive);
  /// Moves the amplifier's target in a straight line from its present value to `drive`. The motion begins at
  /// the present time and takes the duration `time`. `drive` is limited to the amplifier's range.
  void move_target(double drive, can::Duration time);
  /// Replaces the disturbance of the stage from the present time on. Throws std::invalid_argument if
  /// `load_um`, `gain` or `resonance` is not finite, resonance <= 0 or most_drive < 0.
  void disturb(const Disturbance& disturbance);
  /// Couples this stage to the stage `from`: adds `um_per_um` times the motion of `from` since its start to
  /// the position. The coupling is kinematic: it does not excite the modes of this stage. Every read of the
  /// position reads `from`, so `from` must outlive this object.
  void couple(Plant& from, double um_per_um) { couplings_.emplace_back(&from, um_per_um); }

  /// Calls each handler at the end of every sub-step. Its argument is the position of the stage without the
  /// motion that other stages add (see couple()). Between two calls this position is linear in time. A plant
  /// at rest makes one long sub-step, a whole multiple of `substep`, and calls each handler once, at its end.
  using GridHandler = std::function<void(can::Time, double position_um)>;
  void on_grid(GridHandler handler) { on_grid_.push_back(std::move(handler)); }
  /// Adds noise in drive units to the amplifier's output from the next sub-step on. `noise` is called once
  /// for each sub-step, with the time of its start; the value is constant within the sub-step.
  using DriveNoise = std::function<double(can::Time)>;
  void set_drive_noise(DriveNoise noise) { drive_noise_ = std::move(noise); }

  /// Input of the actuator: the amplifier's output and its noise.
  double drive() const { return present_.amplifier.output + noise_; }
  double position_um() const { return own_position_um(present_) + crosstalk_um(); }
  /// Returns the part of the position that comes from the couplings to other stages.
  double crosstalk_um() const;
  /// Returns the output of the hysteresis model, um.
  double hysteresis_um() const { return present_.hysteresis_um; }

 private:
  /// The state of the plant at one time, without the memory of the hysteresis model.
  struct Motion {
    can::Time time;
    Amplifier::State amplifier;
    double hysteresis_um = 0.0;  ///< output of the hysteresis model
    double creep_um = 0.0;       ///< creep of the hysteresis output
    double input_um = 0.0;       ///< input of the mechanical modes: the position to which they settle (u)
    model::SecondOrder::State mode, second_mode;
    model::Creep::State creep;
  };
  /// Objects that advance amplifier, modes and creep by a time step of the length `length`. The factors that
  /// depend on this length are computed only once.
  struct Step {
    Step(const Config& config, const model::Creep::Operators& creep_operators, can::Duration step_length);
    can::Duration length;
    Amplifier amplifier;
    model::SecondOrder mode;
    std::optional<model::SecondOrder> second_mode;
    model::Creep creep;
  };

  /// The remaining motion of the amplifier's target after move_target().
  struct Ramp {
    can::Time end;
    double to = 0.0;
    std::optional<can::Time> turn;  ///< time at which the amplifier's output reverses; nullopt: never
  };

  template <class Hysteresis>
  void move(Motion& motion, const Step& step, Hysteresis hysteresis);
  void go_on_to(can::Time time);
  void pass_turn_or_end();
  double target_of(double drive) const;
  void aim(const Amplifier::State& at);
  void split();
  void begin_substep(can::Duration length);
  bool has_settled();
  bool drifts_evenly() const;
  const Step& step_of(can::Duration length);
  double stroke_um(const Motion& motion) const;
  double input_um(const Motion& motion) const;
  double own_position_um(const Motion& motion) const;

  Config config_;  ///< configuration; its natural frequencies are multiplied by disturbance_.resonance
  model::Creep::Operators creep_;
  double late_share_;  ///< share of the hysteresis output that appears as creep instead of at once
  Disturbance disturbance_;
  Material material_;  ///< material with its memory, at the time settled_.time
  double start_um_;    ///< output of the hysteresis model when the plant was created, um
  can::Time start_;
  Step substep_;
  /// Cache of Step objects for parts of a sub-step. A command splits a sub-step into two parts. Most commands
  /// arrive at the same time after the begin of a sub-step, so the lengths of the parts are often the same.
  std::array<std::optional<Step>, 128> parts_;
  Motion settled_;  ///< state at the end of the last completed sub-step, or of the last part of a sub-step
  Motion present_;  ///< state at the present time
  can::Time next_grid_;
  std::optional<Ramp> ramp_;
  double noise_ = 0.0;
  std::vector<GridHandler> on_grid_;
  DriveNoise drive_noise_;
  std::vector<std::pair<Plant*, double>> couplings_;  ///< a coupled stage, and the share of
                                                      ///< its motion that moves this stage
};

}  // namespace hystcan::twin
