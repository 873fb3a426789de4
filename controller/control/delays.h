// The links between a demand and the resulting position: delays, which the feed-forward compensates, and the
// filters of the control law.
#pragma once

#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

namespace hystcan::controller {

// The delays between a demand and the resulting position, as moments; the feed-forward compensates them.
//
// Each link of the chain (command delay, held drive, amplifier, mode, notch) has gain 1 at rest. Moments of
// links in series add up. About s = 0
//
//   ln G(s) = -mu s + (var / 2) s^2 + O(s^3)
//
//   link                          mu                  var
//   pure delay d                  d                   0
//   drive held for a cycle T      T / 2               T^2 / 12
//   drive interpolated over T     T                   T^2 / 6       held, then the mean over a cycle
//   1 / (1 + tau s)               tau                 tau^2
//   second-order mode             2 zeta / omega      (4 zeta^2 - 2) / omega^2
//
// mu is the mean delay; var is the variance of the impulse response, negative if the mode rings.
// The inverse to second order (derived in docs/theory/control_law.md) is
//
//   1 / G(s) = e^{mu s} (1 - (var / 2) s^2) + O(s^3)

struct Moments {
  double mean_s = 0.0;       ///< mu
  double variance_s2 = 0.0;  ///< var
};
constexpr Moments operator+(const Moments& a, const Moments& b) {
  return {a.mean_s + b.mean_s, a.variance_s2 + b.variance_s2};
}

struct Delays {
  std::chrono::nanoseconds command_delay{0};  ///< from a sample's SYNC until the command takes effect
  double amplifier_bandwidth_Hz = 1e3;        ///< first-order lag of the amplifier
  double resonance_Hz = 100.0;                ///< omega = 2 pi resonance
  double damping_ratio = 0.1;                 ///< zeta
  bool interpolated = false;                  ///< the amplifier moves straight to a setpoint within a cycle
  std::chrono::nanoseconds sensor_delay{0};   ///< from the position to its sample
  double sensor_bandwidth_Hz = 0.0;           ///< first-order lag of the sensor; 0: none
  bool second_order = false;                  ///< compensates mean and variance; else the mean alone
  bool plant_inverse = false;                 ///< compensates the whole chain (PlantInverse)

  /// Time constant of the amplifier.
  double lag_s() const { return 1.0 / (2.0 * std::numbers::pi * amplifier_bandwidth_Hz); }
  Moments moments(double cycle_s) const;
  double preview_s(double cycle_s) const { return moments(cycle_s).mean_s; }
  /// Returns the pure delays from a command to a sample.
  double pure_s() const { return std::chrono::duration<double>(command_delay + sensor_delay).count(); }
  /// Returns the mean delay of the sensor: the sample shows the position of this time ago.
  double sensor_s() const;
  /// Returns the mean delay from the SYNC that a command answers to the sample that shows its effect.
  double to_sample_s(double cycle_s) const { return preview_s(cycle_s) + sensor_s(); }
};

/// True if held setpoints ring a mode whose period is this many cycles of the loop, near 1, 2, ...: the
/// samples hardly show this ringing.
inline bool rings_between_samples(double cycles) {
  constexpr double near = 0.15;
  return cycles > 1.0 - near && std::abs(cycles - std::round(cycles)) < near;
}

/// Returns the feed-forward with which a chain of these moments outputs r(t), to second order. It needs no
/// derivative, because `reference(seconds from now)` is known in advance. With a cycle h it is
///   r(t + mu) - (var / 2) [r(t + mu + h) - 2 r(t + mu) + r(t + mu - h)] / h^2
/// Error: O(s^3) of the chain, and (var / 24) h^2 r'''' of the difference.
template <class Reference>
double second_order_preview(const Moments& moments, double h_s, const Reference& reference) {
  const double here = reference(moments.mean_s);
  const double difference = reference(moments.mean_s + h_s) - 2.0 * here + reference(moments.mean_s - h_s);
  return here - 0.5 * moments.variance_s2 * difference / (h_s * h_s);
}

// The two filters of the control law, both with gain 1 at rest.
//
//   Notch     N(s) = (s^2 + 2 depth width w s + w^2) / (s^2 + 2 width w s + w^2),   w = 2 pi frequency
//
// `depth` is the gain at the frequency (0: blocks it), `width` the damping ratio of the denominator.
// The discrete filter is the bilinear transform with prewarping:
//
//   z = e^{sT},    s -> w (1 - z^-1) / [tan(w T / 2) (1 + z^-1)]
//
// At the notch frequency it has exactly N's value. At any other frequency f it has N's value at
//
//   (w / 2 pi) tan(pi f T) / tan(w T / 2)
//
// Its memory is the last two inputs and outputs. They do not depend on the coefficients, so the coefficients
// can change between two steps without a bump.
//
//   LowPass   y += (1 - e^{-2 pi f dt}) (x - y),   exact for an input held over dt

struct Notch {
  struct Config {
    double frequency_Hz = 100.0;  ///< > 0, < half the rate
    double depth = 0.1;           ///< 0..1, the gain left at the frequency
    double width = 0.5;           ///< > 0, half the width relative to the frequency

    /// Returns the moments of the discrete filter, including its warping, with  theta = (T / 2) / tan(w T /
    /// 2):
    ///   mu  = 2 width (1 - depth) theta
    ///   var = 4 width^2 (1 - depth^2) theta^2
    Moments moments(double cycle_s) const;
  };
  struct Coefficients {
    double b0 = 1.0, b1 = 0.0, b2 = 0.0, a1 = 0.0, a2 = 0.0;
  };
  struct State {
    double input_1 = 0.0, input_2 = 0.0;    ///< one and two steps ago
    double output_1 = 0.0, output_2 = 0.0;  ///< one and two steps ago
  };

  /// Throws std::invalid_argument if a value is out of its range for this cycle.
  static Coefficients design(const Config& config, double cycle_s);
  static double step(const Coefficients& coefficients, State& state, double input);
  /// Passes the input unchanged and updates the memory, so that a notch can be inserted later.
  static double pass(State& state, double input);
  /// Changes the memory as if every past input had been higher by `by`.
  static void shift(State& state, double by);
  static State at_rest(double input) { return {input, input, input, input}; }
};

/// Returns the moments of the chain from demand to position, with the notch if there is one.
Moments chain_moments(const Delays& delays, const std::optional<Notch::Config>& notch, double cycle_s);

/// Computes one step of a low pass with this corner frequency, from `before` towards `input`.
double low_pass(double corner_Hz, double before, double input, double dt_s);

/// Continuous deadband d: returns e - d above d, 0 within +-d, e + d below -d.
double outside_deadband(double error, double deadband);

}  // namespace hystcan::controller
