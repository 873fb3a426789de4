// The control law: one step computes the drive of one cycle. It is a pure step, without clock, socket and
// log.
//
//   u = H^-1( N[ F + kp e + I ] ),     e = r - y,     I += ki e dt
//
//   u        requested drive
//   r, y     reference and measured position, both at the time of the sample; the error e is always r - y
//   F        feed-forward: the reference ahead by the mean delay tau, r(t + tau). Options of Delays replace
//            it by a form of second order, or by the inverse of the plant
//   kp, ki   gains of PI; I is the integral part, dt the time since the last step
//   N        notch
//   H        hysteresis: from a drive to a position; H^-1 is its inverse
//
// PI acts in um, inside the inverse H^-1. Therefore the loop gain is the gain of a linear plant, and the
// memory of the inverse follows exactly the drive that is applied to the actuator.
//
//   structure     H                                feed-forward   PI
//   average       mean of the reference curves     yes            no
//   inverse       recursive memory-based model     yes            no
//   pi            straight line                    no             yes
//   average+pi    mean of the reference curves     yes            yes
//   inverse+pi    recursive memory-based model     yes            yes
//
// If the model has creep (model/output_creep.h), H is the hysteresis H_0 followed by n creep terms with the
// weight w:
//
//   H(u)    = (1 - n w) H_0(u) + w sum_i y_i,   y_i' = (h - y_i) / tau_i
//   H^-1(x) = H_0^-1( (x - w sum_i y_i) / (1 - n w) )
//
// y_i and tau_i are the state and the time constant of creep term i. Under every structure, h is the output
// of the recursive memory-based model at the applied drive.
//
// Options: a low pass and a deadband for e, and a notch N. The low pass acts equally on reference and
// measurement, so it causes no error.
//
// Anti-windup by back-calculation: if range, slew or the thresholds of the model limit the drive, the
// integral is corrected by the excess. The excess, in um, is exactly the amount that all limits removed:
//
//   saturation_excess = N[F + kp e + I] - H(applied drive)
//   I -= alpha saturation_excess,   alpha = 1 - e^{-ki dt / kp},  1 if kp = 0
//
// While the drive is at a limit, I stays at the position of the limit minus F, for any kp. The difference is
// at most ki e dt of one cycle. If F alone is beyond the position that is reached, PI has not caused the
// limit. I is then not reduced, but does not integrate further into the limit.
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

/// The gains of PI: PI(e) = kp e + ki integral(e) dt. The error e and the result are in um.
struct PiGains {
  double kp = 0.0;        ///< proportional gain, um per um
  double ki_per_s = 0.0;  ///< integral gain, 1/s
};

class ControlLaw {
 public:
  /// All members except the model and its creep can change at run time.
  struct Config {
    Structure structure = Structure::inverse_pi;
    model::HysteresisParameters model;
    std::optional<model::OutputCreep::Config> creep{};  ///< empty: the model has no creep
    PiGains pi;
    /// Errors smaller than the deadband count as 0; larger errors are reduced by the deadband.
    double deadband_um = 0.0;
    double measurement_filter_Hz = 0.0;  ///< corner frequency of the error's low pass; 0: no low pass
    std::optional<Notch::Config> notch{};
  };
  struct Input {
    double reference_um = 0.0;  ///< reference with which PI compares the sample
    double previewed_um = 0.0;  ///< output of the feed-forward
    /// Measured position; `nullopt`: the sample is lost, and the law uses the last error.
    std::optional<double> position_um;
    double dt_s = 0.0;     ///< measured time since the last step
    double cycle_s = 0.0;  ///< nominal time of a cycle; the notch is designed for this time
  };
  struct Demand {
    double drive = 0.0;        ///< requested drive, before the gate limits it
    double position_um = 0.0;  ///< demanded position, the input of the inverse model
    std::uint8_t limits = limit::none;
  };

  /// Throws std::invalid_argument if the model or its creep is invalid.
  explicit ControlLaw(const Config& config);

  /// Moves the memory to a drive that was applied without this law, for example on a ramp.
  void follow(double applied_drive) { full_.advance(memory_, applied_drive); }
  /// Sets the creep of the model to its final value. Called after the actuator has rested for a long time at
  /// the last applied drive.
  void settle() { creep_.settle(creep_state_, memory_.output); }
  /// Lets the model creep for dt_s at the last applied drive. Called once in each cycle, before propose().
  void elapse(double dt_s) { creep_.advance(creep_state_, memory_.output, dt_s); }
  /// Starts the law without a jump of the drive, from the last applied drive: the integral is set to the
  /// offset between sensor and model. Returns the position where the reference must start: the measured
  /// position if the structure has PI, otherwise the position of the model.
  double restart(double position_um);
  /// Sets the memory of the model to a known state, and its creep to the final value. Allocates only if the
  /// capacity of `memory` is above the default.
  void remember(const model::HysteresisState& memory) {
    memory_ = memory;
    settle();
  }

  /// Applies everything of `config` except the model and its creep, which need a restart. The drive does not
  /// jump. If the new structure has no PI, the remaining integral decays with the time constant fade_s.
  /// Called between two cycles; does not allocate.
  void retune(const Config& config);
  static constexpr double fade_s = 0.1;

  Demand propose(const Input& input);
  /// Takes the drive that left the gate: moves the memory of the model to this drive and prevents windup of
  /// the integral.
  void commit(double applied_drive);

  /// Returns the position that inverted() predicts for the last applied drive, including creep. inverted() is
  /// the model whose inverse computes the drive; the configured Structure selects it.
  double predicted_um() const;
  const model::Hysteresis& inverted() const;
  /// Returns the recursive memory-based model. Its memory follows the applied drive, even if the configured
  /// Structure inverts another model.
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
  model::HysteresisState memory_;  ///< memory of the recursive model full_; follows every applied drive
  /// The states of the two models without hysteresis: average_, the mean of the reference curves, and line_,
  /// the straight line. These models have no memory, so their states never change.
  model::HysteresisState average_rest_, line_rest_;
  model::OutputCreep creep_;
  model::OutputCreep::State creep_state_;
  Notch::Coefficients notch_;
  double notch_for_s_ = 0.0;  ///< the cycle time for which notch_ was designed; 0: not designed yet
  Notch::State notch_state_;
  double integral_um_ = 0.0;         ///< integral part of PI; without PI: a remaining offset that decays
  double filtered_um_ = 0.0;         ///< error (reference - measured) after the low pass
  double error_um_ = 0.0;            ///< error after the deadband, the input of PI
  double integrated_s_ = 0.0;        ///< time over which the last step integrated the error; 0: no sample
  double integral_before_um_ = 0.0;  ///< the integral before the last step
  double previewed_um_ = 0.0;
  double before_notch_um_ = 0.0;  ///< feed-forward plus PI, the input of the notch
  double demand_um_ = 0.0;        ///< demanded position, after the notch
};

}  // namespace hystcan::controller
