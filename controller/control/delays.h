// The delays of the chain of links from a demand to the resulting position. The feed-forward compensates
// these delays. This file also contains the notch filter and the low pass of the control law.
#pragma once

#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

namespace hystcan::controller {

// The delays from a demand to the resulting position, as two moments; the feed-forward compensates them.
//
// The chain consists of links: command delay, held drive, amplifier, mode, notch. Each link has gain 1 at
// rest. G(s) is the response of the chain, s the Laplace variable. Near s = 0
//
//   ln G(s) = -mu s + (var / 2) s^2 + O(s^3)
//
// mu is the mean delay. var is the variance of the impulse response, which is negative if the mode rings. The
// moments of links in series add up:
//
//   link                          mu                  var
//   pure delay d                  d                   0
//   drive held for a cycle T      T / 2               T^2 / 12
//   drive interpolated over T     T                   T^2 / 6       held, then the mean over a cycle
//   lag 1 / (1 + tau s)           tau                 tau^2         tau: time constant
//   second-order mode             2 zeta / omega      (4 zeta^2 - 2) / omega^2
//
// omega and zeta are the angular frequency and the damping ratio of the mode. The inverse of the chain to
// second order (derived in docs/theory/control_law.md) is
//
//   1 / G(s) = e^{mu s} (1 - (var / 2) s^2) + O(s^3)

struct Moments {
  double mean_s = 0.0;       ///< mean delay of a chain of links
  double variance_s2 = 0.0;  ///< variance of the impulse response; negative if the mode rings
};
constexpr Moments operator+(const Moments& a, const Moments& b) {
  return {a.mean_s + b.mean_s, a.variance_s2 + b.variance_s2};
}

struct Delays {
  std::chrono::nanoseconds command_delay{0};  ///< time from a sample's SYNC until the command takes effect
  double amplifier_bandwidth_Hz = 1e3;        ///< corner frequency of the amplifier's first-order lag
  double resonance_Hz = 100.0;                ///< frequency of the stage's mode
  double damping_ratio = 0.1;                 ///< damping ratio of the mode
  /// True if the amplifier's output moves to each setpoint along a straight line, which takes one cycle.
  bool interpolated = false;
  /// Pure delay of the sensor: a sample shows the position of this time ago.
  std::chrono::nanoseconds sensor_delay{0};
  double sensor_bandwidth_Hz = 0.0;  ///< corner frequency of the sensor's first-order lag; 0: no lag
  /// True: the feed-forward compensates the mean delay and the variance; false: only the mean delay.
  bool second_order = false;
  /// True: the feed-forward inverts the response of all links of the chain (PlantInverse).
  bool plant_inverse = false;

  /// Returns the time constant of the amplifier.
  double lag_s() const { return 1.0 / (2.0 * std::numbers::pi * amplifier_bandwidth_Hz); }
  Moments moments(double cycle_s) const;
  double preview_s(double cycle_s) const { return moments(cycle_s).mean_s; }
  /// Returns the sum of the pure delays from a command to a sample.
  double pure_s() const { return std::chrono::duration<double>(command_delay + sensor_delay).count(); }
  /// Returns the mean delay of the sensor: its pure delay and its lag.
  double sensor_s() const;
  /// Returns the mean time from a SYNC until samples show the effect of the command that answers the sample
  /// of this SYNC.
  double to_sample_s(double cycle_s) const { return preview_s(cycle_s) + sensor_s(); }
};

/// True if the period of the mode is close to a whole number of cycles; `cycles` is this period in cycles.
/// Setpoints that are held for a cycle then make the mode ring between the samples, and the samples hardly
/// show it.
inline bool rings_between_samples(double cycles) {
  constexpr double near = 0.15;
  return cycles > 1.0 - near && std::abs(cycles - std::round(cycles)) < near;
}

/// Returns the present input of a chain with these moments, chosen so that the output of the chain is nearly
/// the reference r(t) (see the inverse of the chain above struct Moments). `reference(x)` returns the
/// reference x seconds from now. With the mean delay mu, the variance var and the cycle h, the result is
///   r(t + mu) - (var / 2) [r(t + mu + h) - 2 r(t + mu) + r(t + mu - h)] / h^2
/// The second difference replaces the second derivative of r, with an error of (var / 24) h^2 r''''.
template <class Reference>
double second_order_preview(const Moments& moments, double h_s, const Reference& reference) {
  const double here = reference(moments.mean_s);
  const double difference = reference(moments.mean_s + h_s) - 2.0 * here + reference(moments.mean_s - h_s);
  return here - 0.5 * moments.variance_s2 * difference / (h_s * h_s);
}

// The two filters of the control law, both with gain 1 at rest.
//
//   Notch     N(s) = (s^2 + 2 depth width w s + w^2) / (s^2 + 2 width w s + w^2),   w = 2 pi frequency_Hz
//
// s is the Laplace variable. `depth` is the gain at the notch frequency (0 blocks it). `width` is the damping
// ratio of the denominator. With a cycle T, the discrete filter is the bilinear transform with prewarping:
//
//   z = e^{sT},    s -> w (1 - z^-1) / [tan(w T / 2) (1 + z^-1)]
//
// At the notch frequency, the discrete filter has exactly the response N. At any other frequency f, it has
// the response that N has at the frequency
//
//   (w / 2 pi) tan(pi f T) / tan(w T / 2)
//
// The state of a notch is its last two inputs and outputs. They do not depend on the coefficients, so the
// coefficients can change between two steps without a jump of the output.
//
//   LowPass   y += (1 - e^{-2 pi f dt}) (x - y),   exact for an input x that is constant over the time dt
//
// y is the output of the low pass, and f its corner frequency.

struct Notch {
  struct Config {
    double frequency_Hz = 100.0;  ///< centre of the notch; above 0, below half the rate of the cycles
    double depth = 0.1;           ///< 0..1, gain at the centre
    double width = 0.5;           ///< > 0, half the width of the notch, relative to its centre

    /// Returns the mean delay mu and the variance var of the discrete filter, including its warping. With the
    /// cycle T, w = 2 pi frequency_Hz and theta = (T / 2) / tan(w T / 2):
    ///   mu  = 2 width (1 - depth) theta
    ///   var = 4 width^2 (1 - depth^2) theta^2
    Moments moments(double cycle_s) const;
  };
  struct Coefficients {
    double b0 = 1.0, b1 = 0.0, b2 = 0.0, a1 = 0.0, a2 = 0.0;
  };
  struct State {
    double input_1 = 0.0, input_2 = 0.0;    ///< inputs one and two steps ago
    double output_1 = 0.0, output_2 = 0.0;  ///< outputs one and two steps ago
  };

  /// Returns the coefficients for this cycle time. Throws std::invalid_argument if a value of `config` is out
  /// of range.
  static Coefficients design(const Config& config, double cycle_s);
  /// Filters one input; returns the output.
  static double step(const Coefficients& coefficients, State& state, double input);
  /// Returns the input unchanged, but updates the state, so that a notch can be inserted later without a
  /// jump.
  static double pass(State& state, double input);
  /// Changes the state as if every past input had been higher by `by`.
  static void shift(State& state, double by);
  static State at_rest(double input) { return {input, input, input, input}; }
};

/// Returns mean delay and variance of the chain from demand to position, with the notch if there is one.
Moments chain_moments(const Delays& delays, const std::optional<Notch::Config>& notch, double cycle_s);

/// Computes one step of a low pass with this corner frequency, from `before` towards `input`.
double low_pass(double corner_Hz, double before, double input, double dt_s);

/// Returns the error after a continuous deadband d: e - d if the error e is above d, 0 within +-d, e + d
/// below -d.
double outside_deadband(double error, double deadband);

}  // namespace hystcan::controller
