// The control law, a pure step: no clock, no socket, no log.
//
//   u = H^-1( r(t + tau) + PI(r(t) - y(t)) )
//
// PI acts in displacement units, inside the inverse H^-1: the loop gain is that of a linear plant, and the
// inverse's memory is exactly the drive that the actuator was given.  Error is reference minus measured,
// everywhere.
//
//   structure     H                                feed-forward   PI
//   average       mean of the reference curves     yes            no
//   inverse       recursive memory-based model     yes            no
//   pi            straight line                    no             yes
//   average+pi    mean of the reference curves     yes            yes
//   inverse+pi    recursive memory-based model     yes            yes
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "controller/gate.h"
#include "model/hysteresis.h"

namespace hystcan::controller {

enum class Structure : std::uint8_t { average, inverse, pi, average_pi, inverse_pi };

inline constexpr std::array all_structures{Structure::average, Structure::inverse, Structure::pi,
                                           Structure::average_pi, Structure::inverse_pi};

std::string_view to_string(Structure structure);
std::optional<Structure> parse_structure(std::string_view text);

/// Proportional and integral action:  PI(e) = kp e + ki integral(e) dt,  e and the result in um.
struct Pi {
  struct Config {
    double kp = 0.0;        ///< um per um
    double ki_per_s = 0.0;  ///< 1/s
  };
  struct State {
    double integral_um = 0.0;  ///< ki integral(e) dt
  };
};

/// The delays between a command and the position it leads to; what the reference is previewed by.
///   tau = command_delay + T / 2 (the drive is held for a cycle) + 1 / (2 pi bandwidth) + 2 zeta / omega
struct Delays {
  std::chrono::nanoseconds command_delay{
      0};                               ///< from the sample's SYNC until the answering command takes effect
  double amplifier_bandwidth_Hz = 1e3;  ///< first-order lag of the amplifier
  double resonance_Hz = 100.0;          ///< omega = 2 pi resonance
  double damping_ratio = 0.1;           ///< zeta

  double preview_s(double cycle_s) const;
};

class ControlLaw {
 public:
  struct Config {
    Structure structure = Structure::inverse_pi;
    model::HysteresisParameters model;
    Pi::Config pi;
  };
  struct Input {
    double reference_um = 0.0;          ///< r(t)
    double previewed_um = 0.0;          ///< r(t + tau)
    std::optional<double> position_um;  ///< y(t); empty: a lost sample, bridged with the last error
    double dt_s = 0.0;                  ///< measured, since the last step
  };
  struct Demand {
    double drive = 0.0;        ///< wanted, before the gate
    double position_um = 0.0;  ///< the displacement that it was inverted from
    std::uint8_t limits = limit::none;
  };

  /// Throws std::invalid_argument where the model is not a valid one.
  explicit ControlLaw(const Config& config);

  /// All memory has been wiped out by driving to the lower threshold. Bumpless in the drive: what offset
  /// there is between sensor and model goes into the integral. Returns the reference to start from: the
  /// measured position, or without feedback the model's.
  double restart_at_lower_threshold(double position_um);

  Demand propose(const Input& input);
  /// Told what left the gate: the memory moves with the drive actually applied; the integral is kept from
  /// winding up.
  void commit(double applied_drive);

  double predicted_um() const { return memory_.output; }  ///< the model's position at the applied drive
  const model::Hysteresis& inverted() const { return inverted_; }

 private:
  Config config_;
  bool feeds_forward_;
  bool feeds_back_;
  model::Hysteresis inverted_;
  model::HysteresisState memory_;
  Pi::State pi_;
  double integral_before_um_ = 0.0;
  double error_um_ = 0.0;
  double demand_um_ = 0.0;
};

}  // namespace hystcan::controller
