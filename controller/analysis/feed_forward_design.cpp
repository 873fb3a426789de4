#include "controller/analysis/feed_forward_design.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace hystcan::controller {
namespace {

using Complex = std::complex<double>;
using Weights = Eigen::Vector<double, ReferenceFilter::size>;

constexpr int reach = ReferenceFilter::reach, weights = ReferenceFilter::size;
constexpr int design_grid = 400;     ///< frequencies from 0 to pi
constexpr double flat_below = 0.03;  ///< theta_0
constexpr int aliases = 6;           ///< m = -6 .. 6

/// The normal equations of the integral, and the two conditions: the weights' sum is 1, their mean is 0.
class FeedForwardFit {
 public:
  /// Adds |1 - path V|^2 + rings |V|^2 at theta, with V about `centre` cycles.
  void add(double theta, double centre, const Complex& path, double rings) {
    const double share = 1.0 / std::pow(theta * theta + flat_below * flat_below, 2);
    Eigen::Vector<Complex, weights> shifts;
    for (int k = 0; k < weights; ++k) shifts[k] = std::polar(1.0, theta * (centre + k - reach));
    normal_.topLeftCorner<weights, weights>() +=
        share * (std::norm(path) + rings) * (shifts.conjugate() * shifts.transpose()).real();
    right_.head<weights>() += share * (std::conj(path) * shifts.conjugate()).real();
  }

  Weights solve() {
    for (int k = 0; k < weights; ++k) {
      normal_(weights, k) = normal_(k, weights) = 1.0;
      normal_(weights + 1, k) = normal_(k, weights + 1) = k - reach;
    }
    right_[weights] = 1.0;
    return normal_.fullPivLu().solve(right_).head<weights>();
  }

 private:
  Eigen::Matrix<double, weights + 2, weights + 2> normal_ =
      Eigen::Matrix<double, weights + 2, weights + 2>::Zero();
  Eigen::Vector<double, weights + 2> right_ = Eigen::Vector<double, weights + 2>::Zero();
};

/// P_m.
Complex path_of(const LoopConfig& loop, const Complex& notch, double theta, int m) {
  const double frequency_Hz = (theta / (2.0 * std::numbers::pi) + m) / loop.cycle_s;
  const double delay_s = std::chrono::duration<double>(loop.delays.command_delay).count();
  return notch * response_between_samples(loop.delays, loop.cycle_s, frequency_Hz) *
         std::polar(1.0, -2.0 * std::numbers::pi * frequency_Hz * delay_s);
}

Weights feed_forward_weights(const LoopConfig& loop, const LinearLoop& linear) {
  const double ahead = chain_moments(loop.delays, loop.notch, loop.cycle_s).mean_s / loop.cycle_s;
  FeedForwardFit fit;
  for (int i = 1; i <= design_grid; ++i) {
    const double theta = std::numbers::pi * i / design_grid;
    const Complex notch = linear.notch(theta);
    double rings = 0.0;
    for (int m = 1; m <= aliases; ++m)
      rings += std::norm(path_of(loop, notch, theta, m)) + std::norm(path_of(loop, notch, theta, -m));
    fit.add(theta, ahead, path_of(loop, notch, theta, 0), rings);
  }
  return fit.solve();
}

}  // namespace

PlantInverse::Config design_plant_inverse(const LoopConfig& loop) {
  PlantInverse::Config inverse{.feed_forward = {}, .plant = HeldPlant(loop.delays, loop.cycle_s).recursion()};
  if (loop.notch) inverse.plant.notch = Notch::design(*loop.notch, loop.cycle_s);
  const Weights found = feed_forward_weights(loop, LinearLoop(loop));
  for (int k = 0; k < weights; ++k) inverse.feed_forward.weights[static_cast<std::size_t>(k)] = found[k];
  return inverse;
}

void plan_feed_forward(AxisConfig& axis, double rate_Hz) {
  axis.plant_inverse.reset();
  if (axis.delays.plant_inverse)
    axis.plant_inverse = design_plant_inverse(loop_config_of(axis.law, axis.delays, 1.0 / rate_Hz));
}

}  // namespace hystcan::controller
