// The two filters of the control law, both with gain 1 at rest.
//
//   Notch     N(s) = (s^2 + 2 depth width w s + w^2) / (s^2 + 2 width w s + w^2),   w = 2 pi frequency
//
// `depth` is the gain at the frequency (0: nothing passes), `width` the damping ratio of the denominator.
// Bilinear, prewarped: with z = e^{sT} and s replaced by w (1 - z^-1) / [tan(w T / 2) (1 + z^-1)] the
// discrete filter has N's value at the frequency itself, and elsewhere that of the frequency
// (w / 2 pi) tan(pi f T) / tan(w T / 2).  Its memory is the last two inputs and outputs, which mean the same
// whatever the coefficients are: they can change between two steps without a bump.
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

    /// Of the discrete filter, its warping included:  mu = 2 width (1 - depth) theta,
    /// var = 4 width^2 (1 - depth^2) theta^2,  theta = (T / 2) / tan(w T / 2).
    Moments moments(double cycle_s) const;
  };
  struct Coefficients {
    double b0 = 1.0, b1 = 0.0, b2 = 0.0, a1 = 0.0, a2 = 0.0;
  };
  struct State {
    double input_1 = 0.0, input_2 = 0.0;    ///< one and two steps ago
    double output_1 = 0.0, output_2 = 0.0;  ///< likewise
  };

  /// Throws std::invalid_argument where a value is out of its range for this cycle.
  static Coefficients design(const Config& config, double cycle_s);
  static double step(const Coefficients& coefficients, State& state, double input);
  /// Without a notch: the memory is kept, so that one can be put in later.
  static double pass(State& state, double input);
  /// As if every input so far had been higher by `by`.
  static void shift(State& state, double by);
  static State at_rest(double input) { return {input, input, input, input}; }
};

/// From demand to position, a notch included.
Moments chain_moments(const Delays& delays, const std::optional<Notch::Config>& notch, double cycle_s);

/// One step of the low pass of this corner frequency, from `before` towards `input`.
double low_pass(double corner_Hz, double before, double input, double dt_s);

/// e without what lies within the deadband, continuous: e - d, 0 or e + d.
double outside_deadband(double error, double deadband);

}  // namespace hystcan::controller
