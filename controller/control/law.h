// The control law, a pure step: no clock, no socket, no log.
//
//   u = H^-1( N[ F + kp e + I ] ),   F = r(t + tau) or as `Delays` has it,   e = r(t) - y(t),   I += ki e dt
//
// PI acts in displacement units, inside the inverse H^-1: the loop gain is that of a linear plant, and the
// inverse's memory is exactly the drive that the actuator was given.  Error is reference minus measured,
// everywhere.
//
// Options: e is low-passed (reference and measurement alike, so that no error comes of it) and loses a
// deadband; N is a notch; H is corrected by a learnt gain and offset.
//
// Anti-windup by back-calculation.  saturation_excess = N[F + kp e + I] - H(applied drive), in um, is exactly
// what all limiters together took (range, slew, the model's threshold):
//   I -= alpha saturation_excess,   alpha = 1 - e^{-ki dt / kp},  1 where kp = 0
// A saturated loop rests at I = limit - F whatever kp, to a cycle's ki e dt.  Where F alone lies beyond what
// was realised the limit is not PI's doing: I is held against the limit instead of being driven off by it.
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

#include "controller/control/adaptation.h"
#include "controller/control/delays.h"
#include "controller/control/filter.h"
#include "controller/control/gate.h"
#include "model/hysteresis.h"
#include "model/words.h"

namespace hystcan::controller {

enum class Structure : std::uint8_t { average, inverse, pi, average_pi, inverse_pi };

constexpr auto words(Structure) {
  return std::to_array<std::string_view>({"average", "inverse", "pi", "average+pi", "inverse+pi"});
}
constexpr std::string_view to_string(Structure structure) { return word_of(structure); }
inline constexpr auto all_structures = every<Structure>();

/// Proportional and integral action:  PI(e) = kp e + ki integral(e) dt,  e and the result in um.
struct Pi {
  struct Config {
    double kp = 0.0;        ///< um per um
    double ki_per_s = 0.0;  ///< 1/s
  };
  struct State {
    double integral_um = 0.0;  ///< ki integral(e) dt; without PI, an offset left over that decays
  };
};

class ControlLaw {
 public:
  /// All but the model can be changed while running.
  struct Config {
    Structure structure = Structure::inverse_pi;
    model::HysteresisParameters model;
    Pi::Config pi;
    double deadband_um = 0.0;            ///< errors within it are none, others smaller by it
    double measurement_filter_Hz = 0.0;  ///< corner of the low pass, 0: none
    std::optional<Notch::Config> notch{};
    std::optional<Adaptation::Config> adaptation{};
  };
  struct Input {
    double reference_um = 0.0;          ///< r(t)
    double previewed_um = 0.0;          ///< F
    std::optional<double> position_um;  ///< y(t); empty: a lost sample, bridged with the last error
    double dt_s = 0.0;                  ///< measured, since the last step
    double cycle_s = 0.0;               ///< nominal: what a notch is designed for
    bool steady = false;                ///< nothing under way that the correction should not learn from
  };
  struct Demand {
    double drive = 0.0;        ///< wanted, before the gate
    double position_um = 0.0;  ///< the displacement that it was inverted from
    std::uint8_t limits = limit::none;
  };

  /// Throws std::invalid_argument where the model is not a valid one.
  explicit ControlLaw(const Config& config);

  /// A drive was applied while the law was not asked: the memory moves with it.
  void follow(double applied_drive) { full_.advance(memory_, applied_drive); }
  /// From the drive that was applied last. Bumpless in the drive: what offset there is between sensor and
  /// model goes into the integral. Returns the reference to start from: the measured position, or without
  /// feedback the model's.
  double restart(double position_um);
  /// A memory known from elsewhere. Allocates only where its capacity is above the default.
  void remember(const model::HysteresisState& memory) { memory_ = memory; }
  /// The same after all memory has been wiped out by driving to the lower threshold.
  double restart_at_lower_threshold(double position_um);

  /// Between two cycles, without allocating: everything of `config` but the model, which is not looked at (a
  /// change of it needs a restart). The drive does not jump. Without PI in the new structure, what offset is
  /// left over decays over fade_s.
  void retune(const Config& config);
  static constexpr double fade_s = 0.1;

  Demand propose(const Input& input);
  /// Told what left the gate: the memory moves with the drive actually applied; the integral is kept from
  /// winding up.
  void commit(double applied_drive);

  /// The model's position at the applied drive.
  double predicted_um() const { return correction_.apply(modelled_um()); }
  const model::Hysteresis& inverted() const;
  /// The recursive model, whose memory moves under every structure.
  const model::Hysteresis& model() const { return full_; }
  const model::HysteresisState& memory() const { return memory_; }
  double integral_um() const { return pi_.integral_um; }

  const ModelCorrection& correction() const { return correction_; }
  /// Bumpless, and within the bounds; {} reverts. No effect without `adaptation`.
  void set_correction(const ModelCorrection& correction);

 private:
  bool feeds_forward() const { return config_.structure != Structure::pi; }
  bool feeds_back() const {
    return config_.structure != Structure::average && config_.structure != Structure::inverse;
  }
  double feed_forward_um() const { return feeds_forward() ? previewed_um_ : 0.0; }
  double proportional_um() const { return feeds_back() ? config_.pi.kp * error_um_ : 0.0; }
  const model::HysteresisState& inverted_memory() const;
  double modelled_um() const;

  void take_error(const Input& input);
  void integrate(double dt_s);
  double notched(double demand_um, double cycle_s);
  void keep_from_winding_up(double unmet_um);
  void enter_structure();
  void move_correction(const ModelCorrection& to);

  Config config_;
  model::Hysteresis full_, average_, line_;
  model::HysteresisState memory_;                    ///< of the full model, under every structure
  model::HysteresisState average_rest_, line_rest_;  ///< of the curves without memory: never moved
  ModelCorrection correction_;
  Notch::Coefficients notch_;
  double notch_for_s_ = 0.0;  ///< the cycle that notch_ was designed for; 0: none yet
  Notch::State notch_state_;
  Pi::State pi_;
  double filtered_um_ = 0.0;   ///< r - y after the low pass
  double error_um_ = 0.0;      ///< after the deadband too: what PI sees
  double integrated_s_ = 0.0;  ///< in the last step; 0: its sample was lost
  double before_um_ = 0.0;     ///< the integral before the last step
  double previewed_um_ = 0.0;
  double demand_um_ = 0.0;   ///< F + PI
  double notched_um_ = 0.0;  ///< what the inverse was asked for
  bool steady_ = false;
};

}  // namespace hystcan::controller
