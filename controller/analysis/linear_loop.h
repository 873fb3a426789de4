// The linear plant of the loop, the closed loop in the samples, and its margins.
#pragma once

#include <Eigen/Core>

#include <complex>
#include <optional>

#include "controller/control/delays.h"
#include "controller/control/law.h"
#include "controller/control/plant_inverse.h"

namespace hystcan::controller {

// The linear plant once per cycle: from the drive's setpoint to the sample.
//
// With the inverse of the hysteresis the actuator is linear with gain 1 (docs/theory/identification.md). The
// rest is a chain of links with gain 1 at rest: amplifier and sensor (first order), mode (second order), a
// pure delay d.
//
//   G(s) = e^{-ds} prod_i p_i / (p_i - s)                               p_i: the poles, all different
//
// Setpoints change once in a cycle T. The sum over the steps of all cycles is the exact response of the
// samples, for any delay. With j = ceil(d / T), tau = j T - d, w = 1 / z and
//
//   E_i = e^{p_i tau} / (1 - e^{p_i T} w)
//
// the response is
//
//   held          G(z) = w^j [1 + (1 - w) sum_i c_i E_i]
//   interpolated  G(z) = w^j [w + (1 - w)(tau - sum_i c_i / p_i) / T + (1 - w)^2 / T sum_i (c_i / p_i) E_i]
//
// Interpolated: the amplifier moves in a straight line from the last setpoint to the new one, within one
// cycle.

/// Returns the plant as a recursion, without a notch. `longer_s` is added to the delays. Throws
/// std::invalid_argument if a parameter is not finite or out of range.
///
///   share      c_i e^{p_i tau} held,  c_i e^{p_i tau} / (p_i T) interpolated
///   constant   (tau - sum c_i / p_i) / T
PlantRecursion::Config held_plant(const Delays& delays, double cycle_s, double longer_s = 0.0);

/// Returns the plant's frequency response G(e^{i theta}), theta = 2 pi f T.
std::complex<double> response_of(const PlantRecursion::Config& held_plant, double theta);

/// Returns the response from the setpoints to the position between the samples, without pure delays and
/// sensor:
///
///   P(s) = h(s) / (1 + s / w_a) * w^2 / (s^2 + 2 zeta w s + w^2),
///   h = (1 - e^{-sT}) / (sT) held,  h^2 interpolated
///
/// w_a is the corner frequency of the amplifier; w and zeta belong to the mode; T is a cycle.
std::complex<double> response_between_samples(const Delays& delays, double cycle_s, double frequency_Hz);

// The closed loop in the samples. The commands tune, check, ctl and reload all judge a loop by this model.
//
//   L(z) = PI(z) F(z) P(z),   P(z) = N(z) G(z),   z = e^{i theta},  0 < theta <= pi
//
//   PI = kp + ki T z / (z - 1)                     controller/control/law.h
//   F                                              low pass of the error (measurement_filter_Hz)
//   N                                              notch of the demand
//   G                                              the held plant with all delays (held_plant)

/// The controller and plant of a closed loop, and the feed-forward of the reference.
struct LoopConfig {
  Delays delays;
  double cycle_s = 1e-3;
  PiGains pi{};
  double measurement_filter_Hz = 0.0;  ///< corner frequency; 0: no filter
  std::optional<Notch::Config> notch{};
  Structure structure = Structure::inverse_pi;
};
LoopConfig loop_config_of(const ControlLaw::Config& law, const Delays& delays, double cycle_s);

/// Returns the response of PI, kp + ki T z / (z - 1).
std::complex<double> pi_response(const PiGains& pi, double cycle_s, double theta);

class LinearLoop {
 public:
  /// `longer_s` is added to the plant's delays. Throws std::invalid_argument if a parameter is out of range.
  explicit LinearLoop(const LoopConfig& config, double longer_s = 0.0);

  const LoopConfig& config() const { return config_; }

  /// Returns N, the response of the notch.
  std::complex<double> notch(double theta) const;
  /// Returns P, the response from the demand to the sample.
  std::complex<double> plant(double theta) const;
  /// Returns F P, the loop without its gains.
  std::complex<double> without_gains(double theta) const;
  /// without_gains() in two parts: unfiltered() is the plant alone; filtered() adds notch and low pass to a
  /// plant's response.
  std::complex<double> unfiltered(double theta) const { return response_of(plant_, theta); }
  std::complex<double> filtered(double theta, const std::complex<double>& plant) const {
    return filter(theta) * (notch(theta) * plant);
  }
  /// Returns L, the response of the open loop with these gains.
  std::complex<double> operator()(const PiGains& pi, double theta) const {
    return pi_response(pi, config_.cycle_s, theta) * without_gains(theta);
  }

 private:
  std::complex<double> filter(double theta) const;

  LoopConfig config_;
  PlantRecursion::Config plant_;
  Notch::Coefficients coefficients_;
  double filter_pole_ = 0.0;  ///< e^{-2 pi f T}
};

// Distance of a loop from instability, and its speed.
//
// Stability follows from Nyquist's criterion in the samples: the plant has no pole outside the unit circle,
// so the loop is stable exactly if 1 + L does not wind around zero on 0 < theta <= pi.

struct Margins {
  bool stable = false;
  double phase_margin_deg = 0.0;  ///< smallest phase margin of all crossovers
  double gain_margin = 0.0;       ///< smallest gain margin, as a factor
  double peak_beyond_180 = 0.0;   ///< largest |L| at a phase of -180 degrees or beyond, unwrapped
  double peak_sensitivity = 0.0;  ///< max 1 / |1 + L|
  double crossover_Hz = 0.0;      ///< lowest frequency with |L| = 1; 0 if there is none
  double bandwidth_Hz = 0.0;      ///< lowest frequency with |L / (1 + L)| = 1 / sqrt(2); 0 if there is none
};

/// Returns theta from 1e-4 pi to pi, ascending: even steps, logarithmic steps for slow loops, and a cluster
/// around the (aliased) resonance. `density`: 1 for margins; less for a search.
Eigen::ArrayXd frequencies_for(const LoopConfig& config, double density = 1.0);

/// The loop at several frequencies, without its gains: L = ki T integral + kp proportional.
struct Responses {
  Eigen::ArrayXcd integral, proportional;
};
/// Returns the responses at the frequencies that margins_of() uses.
Responses responses_of(const LinearLoop& loop);

/// Throws std::invalid_argument if a gain is negative or not finite.
Margins margins_of(const LinearLoop& loop, const PiGains& pi);

/// Returns the worse value of each margin.
Margins worse_of(const Margins& a, const Margins& b);

/// Returns the present kp with the largest stable ki, rounded down to two digits. If no ki is stable with
/// this kp, returns the largest stable kp and ki = 0.
PiGains largest_stable_gains(const LinearLoop& loop, const PiGains& pi);

}  // namespace hystcan::controller
