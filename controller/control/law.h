// The control law, a pure step: no clock, no socket, no log.
//
//   u = H^-1( N[ F + kp e + I ] ),   F = r(t + tau), or to second order (Delays)
//   e = r(t) - y(t),   I += ki e dt
//
// PI acts in displacement units, inside the inverse H^-1: the loop gain is the gain of a linear plant, and
// the inverse's memory follows exactly the drive applied to the actuator. The error is always reference minus
// measured.
//
// If the model has creep (model/output_creep.h), H is the hysteresis H_0 with the creep behind it:
//
//   H(u)    = (1 - n w) H_0(u) + w sum_i y_i,   y_i' = (h - y_i) / tau_i
//   H^-1(x) = H_0^-1( (x - w sum_i y_i) / (1 - n w) )
//
// h is the output of the recursive memory-based model at the applied drive, under every structure.
//
// Options: a low pass and a deadband for e, and a notch N. The low pass acts equally on reference and
// measurement, so it causes no error.
//
// Anti-windup by back-calculation: the excess, in um, is exactly the amount that all limiters (range, slew,
// the model's thresholds) removed:
//
//   saturation_excess = N[F + kp e + I] - H(applied drive)
//   I -= alpha saturation_excess,   alpha = 1 - e^{-ki dt / kp},  1 if kp = 0
//
// A saturated loop rests at I = limit - F for any kp, within one cycle's ki e dt. If F alone exceeds the
// realised position, PI has not caused the limit: I is then not reduced, and it stops integrating further
// into the limit.
//
//   structure     H                                feed-forward   PI
//   average       mean of the reference curves     yes            no
//   inverse       recursive memory-based model     yes            no
//   pi            straight line                    no             yes
//   average+pi    mean of the reference curves     yes            yes
//   inverse+pi    recursive memory-based model     yes            yes
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/words.h"
#include "controller/control/delays.h"
#include "controller/control/gate.h"
#include "model/hysteresis.h"
#include "model/output_creep.h"

namespace hystcan::controller {

enum class Structure : std::uint8_t { average, inverse, pi, average_pi, inverse_pi };

constexpr auto words(Structure) {
  return std::to_array<std::string_view>({"average", "inverse", "pi", "average+pi", "inverse+pi"});
}
constexpr std::string_view to_string(Structure structure) { return word_of(structure); }
inline constexpr auto all_structures = every<Structure>();
constexpr bool feeds_forward(Structure structure) { return structure != Structure::pi; }
constexpr bool feeds_back(Structure structure) {
  return structure != Structure::average && structure != Structure::inverse;
}

/// Proportional and integral action:  PI(e) = kp e + ki integral(e) dt,  e and the result in um.
struct PiGains {
  double kp = 0.0;        ///< um per um
  double ki_per_s = 0.0;  ///< 1/s
};

class ControlLaw {
 public:
  /// All members except the model and its creep can change at run time.
  struct Config {
    Structure structure = Structure::inverse_pi;
    model::HysteresisParameters model;
    std::optional<model::OutputCreep::Config> creep{};  ///< creep of the model
    PiGains pi;
    /// Smaller errors count as 0, larger ones are reduced by the deadband.
    double deadband_um = 0.0;
    double measurement_filter_Hz = 0.0;  ///< corner of the low pass; 0: no low pass
    std::optional<Notch::Config> notch{};
  };
  struct Input {
    double reference_um = 0.0;          ///< r(t)
    double previewed_um = 0.0;          ///< F, the output of the feed-forward
    std::optional<double> position_um;  ///< y(t); `nullopt`: the sample is lost, and the last error is used
    double dt_s = 0.0;                  ///< measured time since the last step
    double cycle_s = 0.0;               ///< nominal cycle; the notch is designed for it
  };
  struct Demand {
    double drive = 0.0;        ///< requested, before the gate
    double position_um = 0.0;  ///< input of the inverse
    std::uint8_t limits = limit::none;
  };

  /// Throws std::invalid_argument if the model or its creep is invalid.
  explicit ControlLaw(const Config& config);

  /// Moves the memory to a drive that was applied without this law, for example on a ramp.
  void follow(double applied_drive) { full_.advance(memory_, applied_drive); }
  /// Called after the actuator has rested for a long time at the last applied drive: its creep is complete.
  void settle() { creep_.settle(creep_state_, memory_.output); }
  /// Lets the model creep for dt_s at the last applied drive. Called once in each cycle, before propose().
  void elapse(double dt_s) { creep_.advance(creep_state_, memory_.output, dt_s); }
  /// Starts without a bump from the last applied drive: the integral is set to the offset between sensor and
  /// model. Returns the reference to start from: the measured position with feedback, else the model's
  /// position.
  double restart(double position_um);
  /// Sets a known memory, and settles. Allocates only if the memory's capacity is above the default.
  void remember(const model::HysteresisState& memory) {
    memory_ = memory;
    settle();
  }

  /// Called between two cycles; does not allocate. Applies everything of `config` except the model and its
  /// creep, which need a restart. The drive does not jump. If the new structure has no PI, the remaining
  /// offset decays over fade_s.
  void retune(const Config& config);
  static constexpr double fade_s = 0.1;

  Demand propose(const Input& input);
  /// Takes the drive that left the gate: moves the memory to it and prevents windup of the integral.
  void commit(double applied_drive);

  /// Returns the model's present position at the applied drive.
  double predicted_um() const;
  const model::Hysteresis& inverted() const;
  /// The recursive model; its memory follows the drive with every structure.
  const model::Hysteresis& model() const { return full_; }
  const model::HysteresisState& memory() const { return memory_; }
  double integral_um() const { return integral_um_; }

 private:
  bool feeds_forward() const { return controller::feeds_forward(config_.structure); }
  bool feeds_back() const { return controller::feeds_back(config_.structure); }
  double feed_forward_um() const { return feeds_forward() ? previewed_um_ : 0.0; }
  double proportional_um() const { return feeds_back() ? config_.pi.kp * error_um_ : 0.0; }
  const model::HysteresisState& inverted_memory() const;

  void update_error(const Input& input);
  void integrate(double dt_s);
  double notched(double before_um, double cycle_s);
  void prevent_windup(double excess_um);
  void enter_structure();

  Config config_;
  model::Hysteresis full_, average_, line_;
  model::HysteresisState memory_;                    ///< memory of the full model, with every structure
  model::HysteresisState average_rest_, line_rest_;  ///< states of the models without memory: constant
  model::OutputCreep creep_;
  model::OutputCreep::State creep_state_;
  Notch::Coefficients notch_;
  double notch_for_s_ = 0.0;  ///< the cycle time for which notch_ was designed; 0: not designed yet
  Notch::State notch_state_;
  double integral_um_ = 0.0;         ///< ki integral(e) dt; without PI: a remaining offset that decays
  double filtered_um_ = 0.0;         ///< r - y after the low pass
  double error_um_ = 0.0;            ///< after the deadband: the input of PI
  double integrated_s_ = 0.0;        ///< time over which the last step integrated; 0: the sample was lost
  double integral_before_um_ = 0.0;  ///< the integral before the last step
  double previewed_um_ = 0.0;
  double before_notch_um_ = 0.0;  ///< feed-forward plus PI, the input of the notch
  double demand_um_ = 0.0;        ///< input of the inverse, after the notch
};

}  // namespace hystcan::controller
