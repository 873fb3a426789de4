// The loop as it is closed in the samples, everywhere the same: tune, dynamics, check, ctl and reload judge by it.
//
//   L(z) = PI(z) F(z) P(z),   P(z) = N(z) G(z),   z = e^{i theta},  0 < theta <= pi
//
//   PI = kp + ki T z / (z - 1)                     controller/control/law.h
//   F                                              low pass of the error (measurement_filter_Hz)
//   N                                              notch of the demand
//   G                                              the held plant with all delays (controller/analysis/held_plant.h)
#pragma once

#include <complex>
#include <optional>

#include "controller/analysis/held_plant.h"
#include "controller/control/filter.h"
#include "controller/control/law.h"

namespace hystcan::controller {

/// What closes the loop beside the gains, and what the reference does in it.
struct LoopConfig {
  Delays delays;
  double cycle_s = 1e-3;
  double measurement_filter_Hz = 0.0;  ///< 0: none
  std::optional<Notch::Config> notch{};
  Structure structure = Structure::inverse_pi;
};
LoopConfig loop_config_of(const ControlLaw::Config& law, const Delays& delays, double cycle_s);

/// PI without a number of its own: kp + ki T z / (z - 1).
std::complex<double> pi_response(const Pi::Config& pi, double cycle_s, double theta);

class LinearLoop {
 public:
  /// `longer_s` is added to the plant's delays. Throws std::invalid_argument where a parameter is out of range.
  explicit LinearLoop(const LoopConfig& config, double longer_s = 0.0);

  const LoopConfig& config() const { return config_; }

  /// N.
  std::complex<double> notch(double theta) const;
  /// P, from the demand to the sample.
  std::complex<double> plant(double theta) const;
  /// F P: the loop without its gains.
  std::complex<double> without_gains(double theta) const;
  /// without_gains() in two parts: the plant alone, and a plant's response behind notch and low pass.
  std::complex<double> unfiltered(double theta) const { return plant_.response(theta); }
  std::complex<double> filtered(double theta, const std::complex<double>& plant) const {
    return filter(theta) * (notch(theta) * plant);
  }
  /// L.
  std::complex<double> operator()(const Pi::Config& pi, double theta) const {
    return pi_response(pi, config_.cycle_s, theta) * without_gains(theta);
  }

 private:
  std::complex<double> filter(double theta) const;

  LoopConfig config_;
  HeldPlant plant_;
  Notch::Coefficients coefficients_;
  double filter_pole_ = 0.0;  ///< e^{-2 pi f T}
};

}  // namespace hystcan::controller
