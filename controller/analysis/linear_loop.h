// The linear model of the closed loop: its plant, its frequency response, and its margins. It is a
// discrete-time model: each signal has one value per cycle.
#pragma once

#include <Eigen/Core>

#include <complex>
#include <optional>

#include "controller/control/delays.h"
#include "controller/control/law.h"
#include "controller/control/plant_inverse.h"

namespace hystcan::controller {

// The linear plant in discrete time: from the setpoints of the drive to the samples of the position, one
// value per cycle.
//
// With the inverse of the hysteresis, the actuator is linear with gain 1 (docs/theory/identification.md). The
// rest of the plant is a chain of links with gain 1 at rest: amplifier and sensor (first order), mode (second
// order), and a pure delay d:
//
//   G(s) = e^{-ds} prod_i p_i / (p_i - s)           s: Laplace variable, p_i: the poles, all different
//
// A setpoint changes once in a cycle T. It is held for the cycle, or interpolated: the amplifier moves in a
// straight line from the last setpoint to the new one, within one cycle. The sum of the step responses to all
// changes is the exact response of the samples, for any delay:
//
//   held          G(z) = w^j [1 + (1 - w) sum_i c_i E_i]
//   interpolated  G(z) = w^j [w + (1 - w)(tau - sum_i c_i / p_i) / T + (1 - w)^2 / T sum_i (c_i / p_i) E_i]
//
//   z, w      shift by one cycle forward, w = 1 / z
//   j, tau    delay in cycles, rounded up, j = ceil(d / T); time from d to j cycles, tau = j T - d
//   c_i       coefficient of pole i in the step response 1 + sum_i c_i e^{p_i t}
//   E_i       decay of pole i, summed over all later cycles n = 0, 1, 2, ...:
//             E_i = sum_n e^{p_i (tau + n T)} w^n = e^{p_i tau} / (1 - e^{p_i T} w)

/// Returns the plant as a recursion from cycle to cycle, without a notch. `longer_s` is added to the pure
/// delays. Throws std::invalid_argument if a parameter is not finite or out of range. The result contains:
///
///   delay_cycles   j, the sum d of the pure delays in cycles T, rounded up: j = ceil(d / T)
///   share          c_i e^{p_i tau} held,  c_i e^{p_i tau} / (p_i T) interpolated; one for each pole p_i
///   constant       (tau - sum c_i / p_i) / T, used if the drive is interpolated
///
/// tau = j T - d is the time from the end of the delay to the next cycle. c_i is the coefficient of the pole
/// p_i in the step response of the plant.
PlantRecursion::Config held_plant(const Delays& delays, double cycle_s, double longer_s = 0.0);

/// Returns the response of the plant at the frequency f, with theta = 2 pi f T. T is the cycle, so theta is
/// pi at half the rate.
std::complex<double> response_of(const PlantRecursion::Config& held_plant, double theta);

/// Returns the response from the setpoints to the position, also between the samples. Pure delays and sensor
/// are not included. At the frequency f, with s = 2 pi i f, the response is
///
///   P(s) = h(s) / (1 + s / w_a) * w^2 / (s^2 + 2 zeta w s + w^2)
///
/// h is (1 - e^{-sT}) / (sT) for held setpoints, and the square of this for interpolated ones; T is a cycle.
/// w_a is the corner frequency of the amplifier. w and zeta are the frequency and the damping ratio of the
/// mode.
std::complex<double> response_between_samples(const Delays& delays, double cycle_s, double frequency_Hz);

// The closed loop in discrete time, one value per cycle. The commands tune, check, ctl and reload all judge a
// loop by this model.
//
//   L(z) = PI(z) F(z) P(z),   P(z) = N(z) G(z),   z = e^{i theta},  0 < theta <= pi
//
//   L        response of the open loop; theta: frequency, pi at half the rate
//   PI       kp + ki T z / (z - 1), with the gains kp and ki and the cycle T (controller/control/law.h)
//   F        low pass of the error (measurement_filter_Hz)
//   P        response from the demand to the sample
//   N        notch of the demand
//   G        plant with all delays (held_plant)

/// A closed loop with its plant and its controller, and the feed-forward of the reference.
struct LoopConfig {
  Delays delays;
  double cycle_s = 1e-3;
  PiGains pi{};
  double measurement_filter_Hz = 0.0;  ///< corner frequency of the low pass for the error; 0: no low pass
  std::optional<Notch::Config> notch{};
  Structure structure = Structure::inverse_pi;
};
LoopConfig loop_config_of(const ControlLaw::Config& law, const Delays& delays, double cycle_s);

/// Returns the response of PI at the frequency theta: kp + ki T z / (z - 1), with z = e^{i theta} and the
/// cycle T.
std::complex<double> pi_response(const PiGains& pi, double cycle_s, double theta);

class LinearLoop {
 public:
  /// Constructs the loop. `longer_s` is added to the pure delays of the plant. Throws std::invalid_argument
  /// if a parameter is out of range.
  explicit LinearLoop(const LoopConfig& config, double longer_s = 0.0);

  const LoopConfig& config() const { return config_; }

  /// Returns the response of the notch; 1 if there is no notch.
  std::complex<double> notch(double theta) const;
  /// Returns the response from the demand to the sample: notch and plant.
  std::complex<double> plant(double theta) const;
  /// Returns the response of the open loop without the gains of PI: low pass, notch and plant.
  std::complex<double> without_gains(double theta) const;
  /// The two parts of without_gains(): unfiltered() is the response of the plant alone, and filtered() adds
  /// the notch and the low pass to the response of a plant.
  std::complex<double> unfiltered(double theta) const { return response_of(plant_, theta); }
  std::complex<double> filtered(double theta, const std::complex<double>& plant) const {
    return filter(theta) * (notch(theta) * plant);
  }
  /// Returns the response of the open loop with the gains `pi`.
  std::complex<double> operator()(const PiGains& pi, double theta) const {
    return pi_response(pi, config_.cycle_s, theta) * without_gains(theta);
  }

 private:
  std::complex<double> filter(double theta) const;

  LoopConfig config_;
  PlantRecursion::Config plant_;
  Notch::Coefficients coefficients_;
  /// Pole of the low pass, e^{-2 pi f T}; f: its corner, T: cycle; 0: no low pass.
  double filter_pole_ = 0.0;
};

// The margins of a loop: its distance from instability, and its speed.
//
// Nyquist's criterion for discrete time decides if the loop is stable. The plant has no pole outside the unit
// circle. Therefore the loop is stable exactly if 1 + L does not wind around zero on 0 < theta <= pi. L is
// the response of the open loop, theta the frequency (pi at half the rate).

struct Margins {
  bool stable = false;
  double phase_margin_deg = 0.0;  ///< smallest phase margin of all crossovers
  double gain_margin = 0.0;       ///< smallest gain margin, as a factor
  double peak_beyond_180 = 0.0;   ///< largest open-loop gain at an unwrapped phase of -180 degrees or less
  double peak_sensitivity = 0.0;  ///< maximum of 1 / |1 + L| over all frequencies; L: open loop
  double crossover_Hz = 0.0;      ///< lowest frequency with an open-loop gain of 1; 0 if there is none
  double bandwidth_Hz = 0.0;      ///< lowest frequency with a closed-loop gain of 1 / sqrt(2); 0: none
};

/// Returns the frequencies theta at which a loop is evaluated, ascending, from 1e-7 pi to pi (half the rate).
/// They have equal steps, and in addition logarithmic steps for slow loops, and small steps around the
/// resonance or its alias. `density`: 1 for margins; less for a search.
Eigen::ArrayXd frequencies_for(const LoopConfig& config, double density = 1.0);

/// The open loop at several frequencies, in two parts that do not depend on the gains kp and ki. The response
/// of the loop is ki T `integral` + kp `proportional`, with the cycle T.
struct Responses {
  Eigen::ArrayXcd integral, proportional;
};
/// Returns the response of the open loop as its integral and its proportional part, without the gains kp and
/// ki, at the frequencies that margins_of() uses.
Responses responses_of(const LinearLoop& loop);

/// Returns the margins of the loop with these gains. Throws std::invalid_argument if a gain is negative or
/// not finite.
Margins margins_of(const LinearLoop& loop, const PiGains& pi);

/// Returns the worse one of the two values of each margin.
Margins worse_of(const Margins& a, const Margins& b);

/// Returns the kp of `pi` and the largest ki with which the loop is stable, rounded down to two digits. If
/// the loop is unstable with this kp and every ki, returns the largest stable kp and ki = 0.
PiGains largest_stable_gains(const LinearLoop& loop, const PiGains& pi);

}  // namespace hystcan::controller
