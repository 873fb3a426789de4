#include "model/second_order.h"

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/text.h"

namespace hystcan::model {
namespace {

using Matrix = Eigen::Matrix<long double, 4, 4>;

// Responses from rest over tau = omega t < 1, from Taylor series:
//   h          to an impulse:  h'' + 2 zeta h' + h = 0,  h(0) = 0,  h'(0) = 1
//   h_slope    h'
//   s          to a step, the integral of h
//   r          to a ramp, the integral of s
// The relative accuracy holds for any length of the step. A closed form in sines would lose the input's share
// (of order tau^2) in a difference of nearly equal numbers.
struct Responses {
  long double h = 0, h_slope = 0, s = 0, r = 0;

  Responses(long double damping_ratio, long double tau) {
    long double before = 0;  // terms j - 1 and j of h's series
    long double term = tau;
    for (int j = 1; std::abs(term) + std::abs(before) > 1e-22L * tau; ++j) {
      h += term;
      h_slope += j * term / tau;
      s += term * tau / (j + 1);
      r += term * tau * tau / ((j + 1) * (j + 2));
      const long double next = -(2 * damping_ratio * j * tau * term + tau * tau * before) / (j * (j + 1));
      before = std::exchange(term, next);
    }
  }
};

// The transition of the augmented state (x, dx/dtau, u, du/dtau) over tau: a short step, squared repeatedly.
Matrix transition(double damping_ratio, long double tau) {
  const long double rate = tau * (2 + 2 * damping_ratio);
  const int halvings = rate > 0.5L ? std::ilogb(rate) + 2 : 0;
  const long double shorter = std::ldexp(tau, -halvings);
  const Responses from_rest(damping_ratio, shorter);
  Matrix step;
  step << 1 - from_rest.s, from_rest.h, from_rest.s, from_rest.r,  //
      -from_rest.h, from_rest.h_slope, from_rest.h, from_rest.s,   //
      0, 0, 1, shorter,                                            //
      0, 0, 0, 1;
  for (int i = 0; i < halvings; ++i) step = (step * step).eval();
  return step;
}

void check(const SecondOrder::Config& config, double dt_s) {
  if (!std::isfinite(config.natural_frequency_Hz) || config.natural_frequency_Hz <= 0)
    refuse("natural_frequency_Hz = ", config.natural_frequency_Hz, ", expected a positive number");
  if (!std::isfinite(config.damping_ratio) || config.damping_ratio < 0)
    refuse("damping_ratio = ", config.damping_ratio, ", expected a number, zero or more");
  if (!std::isfinite(dt_s) || dt_s <= 0) refuse("dt_s = ", dt_s, ", expected a positive number");
}

}  // namespace

SecondOrder::SecondOrder(const Config& config, double dt_s) {
  check(config, dt_s);
  const long double omega = 2 * std::numbers::pi_v<long double> * config.natural_frequency_Hz;
  const long double tau = omega * dt_s;
  if (tau * (1 + 2 * config.damping_ratio) > 1e6L)
    refuse("step of ", dt_s, " s at ", config.natural_frequency_Hz,
           " Hz, expected less than a million time constants");
  const Matrix step = transition(config.damping_ratio, tau);
  const auto from_after = [&](int row) { return step(row, 3) / tau; };
  const auto from_before = [&](int row) { return step(row, 2) - step(row, 3) / tau; };
  position_from_velocity_ = static_cast<double>(step(0, 1) / omega);
  position_from_before_ = static_cast<double>(from_before(0));
  position_from_after_ = static_cast<double>(from_after(0));
  velocity_from_velocity_ = static_cast<double>(step(1, 1));
  velocity_from_before_ = static_cast<double>(from_before(1) * omega);
  velocity_from_after_ = static_cast<double>(from_after(1) * omega);
}

}  // namespace hystcan::model
