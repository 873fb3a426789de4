// How far a loop is from instability, and how fast it is.
//
// Stability by Nyquist's criterion in the samples: the plant has no pole outside the unit circle, so the loop
// is stable exactly when 1 + L does not wind around zero on 0 < theta <= pi.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "controller/analysis/linear_loop.h"

namespace hystcan::controller {

struct Margins {
  bool stable = false;
  double phase_margin_deg = 0.0;  ///< the smallest of all crossovers
  double gain_margin = 0.0;       ///< the smallest; a factor
  double peak_beyond_180 = 0.0;   ///< the largest |L| at a phase of -180 degrees or beyond, unwrapped
  double peak_sensitivity = 0.0;  ///< max 1 / |1 + L|
  double crossover_Hz = 0.0;      ///< the lowest frequency of |L| = 1; 0 if none
  double bandwidth_Hz = 0.0;      ///< lowest frequency with |L / (1 + L)| = 1 / sqrt(2); 0 if none
};

/// theta from 1e-4 pi to pi, ascending: even steps, logarithmic steps for slow loops, and a cluster around
/// the (aliased) resonance. `density`: 1 for margins; less for a search.
Eigen::ArrayXd frequencies_for(const LoopConfig& config, double density = 1.0);

/// The loop at these frequencies, but for its gains: L = ki T integral + kp proportional.
struct Responses {
  Eigen::ArrayXcd integral, proportional;
};
/// At those of margins_of().
Responses responses_of(const LinearLoop& loop);

/// Throws std::invalid_argument where a gain is negative or not finite.
Margins margins_of(const LinearLoop& loop, const Pi::Config& pi);

/// The worst of both, margin by margin.
Margins worse_of(const Margins& a, const Margins& b);

/// The gains that this loop is stable with.
struct StableGains {
  double kp = 0.0;                   ///< the present one, or the largest where that is too large
  std::optional<double> ki_per_s{};  ///< the largest with the present kp; empty: none, kp is too large
};
/// Two digits, rounded down.
StableGains largest_stable_gains(const LinearLoop& loop, const Pi::Config& pi);

}  // namespace hystcan::controller
