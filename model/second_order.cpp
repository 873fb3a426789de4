#include "model/second_order.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/text.h"
#include "model/extended.h"

namespace hystcan::model {
namespace {

using Matrix = std::array<std::array<Extended, 4>, 4>;

Matrix operator*(const Matrix& a, const Matrix& b) {
  Matrix product;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      product[i][j] = (a[i][0] * b[0][j] + a[i][1] * b[1][j]) + (a[i][2] * b[2][j] + a[i][3] * b[3][j]);
  return product;
}

// Responses of the mode from rest after the scaled time tau = omega t < 1, by Taylor series:
//
//   h          to an impulse:  h'' + 2 zeta h' + h = 0,  h(0) = 0,  h'(0) = 1
//   h_slope    h'
//   s          to a step, the integral of h
//   r          to a ramp, the integral of s
//
// The relative error is small even for a very short step. A formula with sines would compute the effect of
// the input, which is of order tau^2, as the difference of nearly equal numbers and lose its digits.
struct Responses {
  Extended h, h_slope, s, r;

  Responses(Extended damping_ratio, Extended tau) {
    // `before` and `term` are the terms with tau^{j-1} and tau^j in the Taylor series of the impulse response
    // h.
    Extended before;
    Extended term = tau;
    for (int j = 1; term.magnitude() + before.magnitude() > 1e-22L * tau; ++j) {
      h += term;
      h_slope += j * term / tau;
      s += term * tau / (j + 1);
      r += term * tau * tau / ((j + 1) * (j + 2));
      const Extended next = -(2 * damping_ratio * j * tau * term + tau * tau * before) / (j * (j + 1));
      before = std::exchange(term, next);
    }
  }
};

// Returns the matrix that advances the state (x, dx/dtau, u, du/dtau) by the scaled time tau. Computes a
// short step and squares its matrix until the step has the length tau.
Matrix transition(double damping_ratio, Extended tau) {
  const Extended rate = tau * (2 + 2 * damping_ratio);
  const int halvings = rate > 0.5L ? std::ilogb(static_cast<double>(rate)) + 2 : 0;
  const Extended shorter = tau * std::ldexp(1.0, -halvings);
  const auto [h, h_slope, s, r] = Responses(damping_ratio, shorter);
  Matrix step{{{1 - s, h, s, r}, {-h, h_slope, h, s}, {0, 0, 1, shorter}, {0, 0, 0, 1}}};
  for (int i = 0; i < halvings; ++i) step = step * step;
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
  const Extended omega = 2 * Extended(std::numbers::pi_v<long double>) * config.natural_frequency_Hz;
  const Extended tau = omega * dt_s;
  if (tau * (1 + 2 * config.damping_ratio) > 1e6L)
    refuse("time step of ", dt_s, " s for a mode of ", config.natural_frequency_Hz,
           " Hz, expected less than a million time constants of the mode");
  const Matrix step = transition(config.damping_ratio, tau);
  const auto from_after = [&](std::size_t row) { return step[row][3] / tau; };
  const auto from_before = [&](std::size_t row) { return step[row][2] - step[row][3] / tau; };
  position_from_velocity_ = static_cast<double>(step[0][1] / omega);
  position_from_before_ = static_cast<double>(from_before(0));
  position_from_after_ = static_cast<double>(from_after(0));
  velocity_from_velocity_ = static_cast<double>(step[1][1]);
  velocity_from_before_ = static_cast<double>(from_before(1) * omega);
  velocity_from_after_ = static_cast<double>(from_after(1) * omega);
}

}  // namespace hystcan::model
