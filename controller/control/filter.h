// The two filters of the control law, both with gain 1 at rest.
//
//   Notch     N(s) = (s^2 + 2 depth width w s + w^2) / (s^2 + 2 width w s + w^2),   w = 2 pi frequency
//
// `depth` is the gain at the frequency (0: nothing passes), `width` the damping ratio of the denominator.
// The discrete filter is the bilinear transform with prewarping:
//
//   z = e^{sT},    s -> w (1 - z^-1) / [tan(w T / 2) (1 + z^-1)]
//
// At the notch frequency it has exactly N's value; at any other frequency f it has N's value at
//
//   (w / 2 pi) tan(pi f T) / tan(w T / 2)
//
// Its memory is the last two inputs and outputs. Their meaning does not depend on the coefficients, so the
// coefficients can change between two steps without a bump.
//
//   LowPass   y += (1 - e^{-2 pi f dt}) (x - y),   exact for an input held over dt
#pragma once

#include <optional>

#include "controller/control/delays.h"

namespace hystcan::controller {

struct Notch {
  struct Config {
    double frequency_Hz = 100.0;  ///< > 0, < half the rate
    double depth = 0.1;           ///< 0..1, the gain left at the frequency
    double width = 0.5;           ///< > 0, half the width relative to the frequency

    /// Moments of the discrete filter, its warping included, with  theta = (T / 2) / tan(w T / 2):
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

  /// Throws std::invalid_argument where a value is out of its range for this cycle.
  static Coefficients design(const Config& config, double cycle_s);
  static double step(const Coefficients& coefficients, State& state, double input);
  /// Passes the input unchanged and keeps the memory up to date, so that a notch can be inserted later.
  static double pass(State& state, double input);
  /// Changes the memory as if every past input had been higher by `by`.
  static void shift(State& state, double by);
  static State at_rest(double input) { return {input, input, input, input}; }
};

/// Moments of the chain from demand to position, with the notch if there is one.
Moments chain_moments(const Delays& delays, const std::optional<Notch::Config>& notch, double cycle_s);

/// One step of a low pass with this corner frequency, from `before` towards `input`.
double low_pass(double corner_Hz, double before, double input, double dt_s);

/// Deadband d, continuous: returns e - d above it, 0 within it, e + d below it.
double outside_deadband(double error, double deadband);

}  // namespace hystcan::controller
